#include "deploy/local/run_directory.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>
#include <system_error>
#include <tuple>

#include "common/config/config_yaml.h"
#include "common/io/atomic_file.h"
#include "common/io/link_file.h"
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

enum class LockState { kTaken, kHeldByOther, kImpossible };

// Where the file system knows no locks of open files, flock(2) does as well: whoever asks falls back alike.
LockState TryLock(const FileDescriptor& file) {
  struct flock exclusive = WholeFile(F_WRLCK);
  if (fcntl(file.get(), F_OFD_SETLK, &exclusive) == 0) return LockState::kTaken;
  if (errno == EAGAIN || errno == EACCES) return LockState::kHeldByOther;
  if (flock(file.get(), LOCK_EX | LOCK_NB) == 0) return LockState::kTaken;
  return errno == EWOULDBLOCK ? LockState::kHeldByOther : LockState::kImpossible;
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
  const LockState state = TryLock(lock);
  if (state == LockState::kImpossible) {
    return Fail(
        ErrorCode::kUnavailable,
        "{} is on a file system without locks, where two trainings could write into one folder: choose a "
        "--run-dir on another",
        paths.root.string());
  }
  if (state == LockState::kHeldByOther) {
    return Fail(ErrorCode::kUnavailable,
                "{} is in use by another dadrl{}: wait for it, stop it, or choose another --run-dir",
                paths.root.string(), Holder(paths));
  }
  // Only for messages: a disk that is full is no obstacle.
  const std::string pid = std::to_string(getpid()) + "\n";
  if (ftruncate(lock.get(), 0) == 0) {
    [[maybe_unused]] const ssize_t written = pwrite(lock.get(), pid.data(), pid.size(), 0);
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
  RunPaths paths{.root = FollowLinks(root)};
  if (!fs::exists(paths.config())) {
    return Fail(
        ErrorCode::kNotFound,
        "{} holds no run (no config.yaml): name one with --run-dir, or start one: dadrl train SCENARIO",
        root.string());
  }
  return Lock(std::move(paths));
}

Status RunDirectory::SaveConfig(const Config& config) const {
  const std::string yaml = ToYaml(config, false);
  if (ReadTextFile(paths_.config(), 2 * yaml.size()) == yaml) return {};
  return WriteFileAtomically(paths_.config(), std::string_view(yaml));
}

Status LoadRunConfig(const RunPaths& paths, Config& config) {
  return LoadYaml(paths.config(), config, Links::kRefuse);
}

void RunDirectory::KeepAcrossExec() const { fcntl(lock_.get(), F_SETFD, 0); }

bool IsRunning(const RunPaths& paths) {
  const auto lock = FileDescriptor::Open(paths.lock(), O_RDONLY);
  if (!lock) return false;
  struct flock query = WholeFile(F_RDLCK);  // asks without taking
  if (fcntl(lock->get(), F_OFD_GETLK, &query) == 0) return query.l_type != F_UNLCK;
  return flock(lock->get(), LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
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
  // Best effort: it saves typing, and a folder of that name is somebody's own.
  std::ignore = LinkAtomically(absolute.parent_path() / "latest", absolute.filename());
}

}  // namespace dadrl
