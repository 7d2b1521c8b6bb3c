#include "replay/storage/snapshot_restore.h"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <cstdint>
#include <system_error>
#include <utility>
#include <vector>

#include "common/io/file_descriptor.h"
#include "common/io/io_error.h"
#include "common/io/mapped_file.h"
#include "replay/storage/columns_file.h"
#include "replay/storage/segment_log.h"
#include "replay/storage/snapshot_folder.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

// Every shard of the run, so that none is forgotten.
Result<std::vector<fs::path>> Snapshots(const fs::path& run, const std::string& name) {
  DADRL_RETURN_IF_ERROR(CheckSnapshotName(name));
  std::vector<fs::path> found;
  std::error_code error;
  for (uint32_t shard = 0;; ++shard) {
    const bool in_run = fs::exists(run / "replay" / fmt::format("shard-{}", shard), error);
    const fs::path snapshot = SnapshotFolder(run, shard) / name;
    if (!in_run && !fs::exists(SnapshotFolder(run, shard), error)) break;
    if (fs::symlink_status(snapshot, error).type() != fs::file_type::directory ||
        !fs::exists(snapshot / "state", error)) {
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

Status CopyFile(const fs::path& from, const fs::path& to) {
  DADRL_ASSIGN_OR_RETURN(const MappedFile source, MappedFile::Open(from));
  DADRL_ASSIGN_OR_RETURN(const FileDescriptor file, FileDescriptor::Open(to, O_WRONLY | O_CREAT | O_EXCL));
  DADRL_RETURN_IF_ERROR(WriteAll(file, source.bytes(), to));
  return SyncFile(file, to);
}

// What a replay would read there, and nothing else; each a regular file of the snapshot itself.
Status LinkFiles(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::create_directories(to, error);
  if (error) return tl::unexpected(IoError("create", to, error.value()));
  for (const fs::directory_entry& entry : fs::directory_iterator(from, error)) {
    const fs::path name = entry.path().filename();
    if (name != "state" && name != kColumnsFile && !SegmentLog::IdOf(name)) continue;
    if (entry.symlink_status(error).type() != fs::file_type::regular) {
      return Fail(ErrorCode::kInvalidArgument,
                  "{} is no regular file of the snapshot: nothing is restored; remove it",
                  entry.path().string());
    }
    fs::create_hard_link(entry.path(), to / name, error);
    if (std::exchange(error, {})) DADRL_RETURN_IF_ERROR(CopyFile(entry.path(), to / name));
  }
  if (error) return tl::unexpected(IoError("list", from, error.value()));
  return SyncDirectory(to);
}

}  // namespace

fs::path ReplacedReplay(const fs::path& run) { return run / "replay.replaced"; }

Status RestoreSnapshot(const fs::path& run, const std::string& name) {
  const fs::path replay = run / "replay";
  const fs::path replaced = ReplacedReplay(run);
  const fs::path restored = run / "replay.restored";
  std::error_code error;
  // An earlier restore ended between its two renames: as if it had not begun.
  if (!fs::exists(replay, error) && fs::exists(replaced, error)) fs::rename(replaced, replay, error);
  DADRL_ASSIGN_OR_RETURN(const std::vector<fs::path> snapshots, Snapshots(run, name));
  if (fs::exists(replaced, error)) {
    return Fail(ErrorCode::kInvalidArgument,
                "{} is still there from an earlier restore; remove it or move it away", replaced.string());
  }
  std::vector<FileDescriptor> locks;
  fs::remove_all(restored, error);
  for (size_t shard = 0; shard < snapshots.size(); ++shard) {
    const std::string folder = fmt::format("shard-{}", shard);
    if (fs::exists(replay / folder, error)) {
      DADRL_ASSIGN_OR_RETURN(FileDescriptor lock, LockShard(replay / folder));
      locks.push_back(std::move(lock));
    }
    if (Status linked = LinkFiles(snapshots[shard], restored / folder); !linked) {
      fs::remove_all(restored, error);
      return linked;
    }
  }
  if (fs::exists(replay, error)) fs::rename(replay, replaced, error);
  if (!error) fs::rename(restored, replay, error);
  if (error) return tl::unexpected(IoError("rename", replay, error.value()));
  return SyncDirectory(run);
}

}  // namespace dadrl
