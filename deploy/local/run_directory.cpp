#include "deploy/local/run_directory.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <ctime>
#include <system_error>

#include "common/config/config_yaml.h"
#include "common/io/atomic_file.h"
#include "common/io/read_file.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

// Locks of the open file (not of the process): released with its last descriptor, and those are O_CLOEXEC
// unless KeepAcrossExec was called.
struct flock WholeFile(short type) {
  struct flock lock {};
  lock.l_type = type;
  lock.l_whence = SEEK_SET;
  return lock;
}

// The pid that the holder wrote: for the message only, the lock itself is the kernel's.
std::string Holder(const RunPaths& paths) {
  const auto text = ReadTextFile(paths.lock(), 64);
  return text && !text->empty() ? fmt::format(" (process {})", text->substr(0, text->find('\n'))) : "";
}

}  // namespace

Result<RunDirectory> RunDirectory::Lock(RunPaths paths) {
  DADRL_ASSIGN_OR_RETURN(FileDescriptor lock, FileDescriptor::Open(paths.lock(), O_RDWR | O_CREAT));
  struct stat info {};
  if (fstat(lock.get(), &info) != 0 || info.st_nlink != 1) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "{} has {} names: the folder was copied with hard links, and a run in it would write into the "
        "other; copy it with cp -a",
        paths.lock().string(), info.st_nlink);
  }
  struct flock exclusive = WholeFile(F_WRLCK);
  if (fcntl(lock.get(), F_OFD_SETLK, &exclusive) != 0) {
    return Fail(ErrorCode::kUnavailable,
                "{} is in use by another dadrl{}: wait for it, stop it, or choose another --run-dir",
                paths.root.string(), Holder(paths));
  }
  const std::string pid = std::to_string(getpid()) + "\n";
  if (ftruncate(lock.get(), 0) != 0 || pwrite(lock.get(), pid.data(), pid.size(), 0) < 0) {
    return Fail(ErrorCode::kInternal, "cannot write {}: {}", paths.lock().string(), std::strerror(errno));
  }
  return RunDirectory(std::move(paths), std::move(lock));
}

Result<RunDirectory> RunDirectory::CreateNew(const fs::path& root) {
  RunPaths paths{.root = root};
  std::error_code error;
  fs::create_directories(root, error);
  if (error || !fs::is_directory(root)) {
    return Fail(ErrorCode::kInvalidArgument, "cannot create run directory {}: {}", root.string(),
                error ? error.message() : "it is not a folder");
  }
  DADRL_ASSIGN_OR_RETURN(RunDirectory run, Lock(paths));
  if (fs::exists(paths.config())) {
    return Fail(ErrorCode::kInvalidArgument,
                "{} holds a run already: --resume goes on with it, another --run-dir starts a new one",
                root.string());
  }
  for (const fs::path& folder : {paths.checkpoints(), paths.replay(), paths.logs(), paths.tensorboard()}) {
    fs::create_directories(folder, error);
    if (error) return Fail(ErrorCode::kInternal, "cannot create {}: {}", folder.string(), error.message());
  }
  return run;
}

Result<RunDirectory> RunDirectory::OpenExisting(const fs::path& root) {
  RunPaths paths{.root = root};
  if (!fs::exists(paths.config())) {
    return Fail(
        ErrorCode::kNotFound,
        "{} holds no run (no config.yaml): name one with --run-dir, or start one: dadrl train SCENARIO",
        root.string());
  }
  return Lock(std::move(paths));
}

Status RunDirectory::SaveConfig(const Config& config) const {
  return WriteFileAtomically(paths_.config(), std::string_view(ToYaml(config, false)));
}

Status LoadRunConfig(const RunPaths& paths, Config& config) {
  return LoadYaml(paths.config(), config, Links::kRefuse);
}

void RunDirectory::KeepAcrossExec() const { fcntl(lock_.get(), F_SETFD, 0); }

bool IsRunning(const RunPaths& paths) {
  const auto lock = FileDescriptor::Open(paths.lock(), O_RDONLY);
  if (!lock) return false;
  struct flock query = WholeFile(F_RDLCK);  // asks without taking
  return fcntl(lock->get(), F_OFD_GETLK, &query) == 0 && query.l_type != F_UNLCK;
}

fs::path NewRunPath(const fs::path& runs, const std::string& scenario) {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  char stamp[32];
  std::strftime(stamp, sizeof stamp, "%Y%m%d-%H%M%S", &local);
  fs::path path = runs / fmt::format("{}-{}", scenario, stamp);
  for (int suffix = 2; fs::exists(path); ++suffix)
    path = runs / fmt::format("{}-{}-{}", scenario, stamp, suffix);
  return path;
}

void LinkLatest(const fs::path& root) {
  std::error_code error;
  const fs::path absolute = fs::absolute(root, error).lexically_normal();
  const fs::path link = absolute.parent_path() / "latest";
  // Beside and renamed: `latest` never points nowhere. Something that is not our link is left alone.
  if (fs::exists(fs::symlink_status(link, error)) && !fs::is_symlink(link, error)) return;
  const fs::path beside = absolute.parent_path() / fmt::format(".latest-{}", getpid());
  fs::create_directory_symlink(absolute.filename(), beside, error);
  if (!error) fs::rename(beside, link, error);
}

}  // namespace dadrl
