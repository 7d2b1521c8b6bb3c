#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <system_error>
#include <vector>

#include "common/io/file_descriptor.h"
#include "common/io/io_error.h"
#include "replay/storage/snapshot_folder.h"
#include "replay/tools/tool.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string run_directory;
  std::string snapshot;
};

// Every shard of the run, so that none is forgotten.
Result<std::vector<fs::path>> Snapshots(const fs::path& run, const std::string& name) {
  DADRL_RETURN_IF_ERROR(CheckSnapshotName(name));
  std::vector<fs::path> found;
  std::error_code error;
  for (uint32_t shard = 0;; ++shard) {
    const bool in_run = fs::exists(run / "replay" / fmt::format("shard-{}", shard), error);
    const fs::path snapshot = SnapshotFolder(run, shard) / name;
    if (!in_run && !fs::exists(SnapshotFolder(run, shard), error)) break;
    if (!fs::exists(snapshot / "state", error)) {
      return Fail(ErrorCode::kNotFound, "there is no snapshot {}; every shard needs one", snapshot.string());
    }
    found.push_back(snapshot);
  }
  if (found.empty()) {
    return Fail(ErrorCode::kNotFound, "{} has neither replay nor snapshots", run.string());
  }
  return found;
}

// Holds off a replay process while its folder is exchanged.
Result<FileDescriptor> LockShard(const fs::path& shard) {
  const fs::path path = shard / "lock";
  DADRL_ASSIGN_OR_RETURN(FileDescriptor lock, FileDescriptor::Open(path, O_RDWR | O_CREAT));
  if (flock(lock.get(), LOCK_EX | LOCK_NB) == 0) return lock;
  return Fail(ErrorCode::kUnavailable, "{} is in use by a replay process; stop the training first",
              shard.string());
}

Status LinkFiles(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::create_directories(to, error);
  if (error) return tl::unexpected(IoError("create", to, error.value()));
  for (const fs::directory_entry& entry : fs::directory_iterator(from, error)) {
    const fs::path target = to / entry.path().filename();
    if (entry.symlink_status(error).type() != fs::file_type::regular) {
      return Fail(ErrorCode::kCorrupt, "{} is no file: a snapshot holds nothing else; remove it",
                  entry.path().string());
    }
    fs::create_hard_link(entry.path(), target, error);
    if (error) fs::copy_file(entry.path(), target, error);
    if (error) return tl::unexpected(IoError("link", target, error.value()));
  }
  if (error) return tl::unexpected(IoError("list", from, error.value()));
  return SyncDirectory(to);
}

Result<int> Restore(const Options& options) {
  const fs::path run = options.run_directory;
  const fs::path replay = run / "replay";
  const fs::path replaced = run / "replay.replaced";
  const fs::path restored = run / "replay.restored";
  std::error_code error;
  // An earlier restore ended between its two renames: as if it had not begun.
  if (!fs::exists(replay, error) && fs::exists(replaced, error)) fs::rename(replaced, replay, error);
  DADRL_ASSIGN_OR_RETURN(const std::vector<fs::path> snapshots, Snapshots(run, options.snapshot));
  if (fs::exists(replaced, error)) {
    return Fail(ErrorCode::kInvalidArgument,
                "{} is still there from an earlier restore; remove it or move it away", replaced.string());
  }
  std::vector<FileDescriptor> locks;
  fs::remove_all(restored, error);
  for (size_t shard = 0; shard < snapshots.size(); ++shard) {
    const std::string name = fmt::format("shard-{}", shard);
    if (fs::exists(replay / name, error)) {
      DADRL_ASSIGN_OR_RETURN(FileDescriptor lock, LockShard(replay / name));
      locks.push_back(std::move(lock));
    }
    DADRL_RETURN_IF_ERROR(LinkFiles(snapshots[shard], restored / name));
  }
  if (fs::exists(replay, error)) fs::rename(replay, replaced, error);
  if (!error) fs::rename(restored, replay, error);
  if (error) return tl::unexpected(IoError("rename", replay, error.value()));
  DADRL_RETURN_IF_ERROR(SyncDirectory(run));
  fmt::print(stderr, "{} is snapshot {} now; what it was is in {}\n", replay.string(), options.snapshot,
             replaced.string());
  return 0;
}

}  // namespace

Tool MakeRestoreTool(CLI::App& replay) {
  auto options = std::make_shared<Options>();
  CLI::App* app = replay.add_subcommand("restore", "Put a snapshot in place of a stopped run's experience");
  app->add_option("--run-dir", options->run_directory, "The run")->required()->type_name("DIR");
  app->add_option("--snapshot", options->snapshot, "Name of the snapshot, as in DIR/snapshots/shard-K/")
      ->required()
      ->type_name("NAME");
  return {app, [options] { return Restore(*options); }};
}

}  // namespace dadrl
