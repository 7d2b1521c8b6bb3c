#include "replay/storage/snapshot.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "common/io/file_descriptor.h"
#include "common/io/io_error.h"
#include "replay/storage/columns_file.h"
#include "replay/storage/snapshot_folder.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

Status Copy(const SegmentLog::Extent& extent, const fs::path& to) {
  DADRL_ASSIGN_OR_RETURN(const FileDescriptor file, FileDescriptor::Open(to, O_WRONLY | O_CREAT | O_EXCL));
  DADRL_RETURN_IF_ERROR(WriteAll(file, extent.segment->Prefix(extent.bytes), to));
  return SyncFile(file, to);
}

Status Add(const SegmentLog::Extent& extent, const fs::path& to, SnapshotReport& report) {
  ++report.segments;
  report.bytes += extent.bytes;
  // Any failure to link - dropped meanwhile, another filesystem, no links there - leaves the copy.
  if (extent.sealed && link(extent.segment->path().c_str(), to.c_str()) == 0) {
    DADRL_RETURN_IF_ERROR(extent.segment->Sync());
    // By this name too: the segment has nothing to force once it was dropped.
    DADRL_ASSIGN_OR_RETURN(const FileDescriptor file, FileDescriptor::Open(to, O_RDONLY));
    return SyncFile(file, to);
  }
  report.copied_bytes += extent.bytes;
  return Copy(extent, to);
}

Status Fill(const ReplayState& state, const StepSpec& spec, std::span<const SegmentLog::Extent> extents,
            const fs::path& directory, SnapshotReport& report) {
  for (const SegmentLog::Extent& extent : extents) {
    DADRL_RETURN_IF_ERROR(Add(extent, directory / extent.segment->path().filename(), report));
  }
  DADRL_RETURN_IF_ERROR(WriteColumns(directory, spec));
  return WriteReplayState(directory / "state", state);
}

}  // namespace

Result<SnapshotReport> WriteSnapshot(const ReplayState& state, const StepSpec& spec,
                                     std::span<const SegmentLog::Extent> extents, const fs::path& directory) {
  std::error_code error;
  if (fs::exists(directory, error)) {
    return Fail(ErrorCode::kInvalidArgument, "{} exists; a snapshot needs a name of its own",
                directory.string());
  }
  const fs::path partial = PartialSnapshot(directory);
  fs::remove_all(partial, error);
  fs::create_directories(partial, error);
  if (error) return tl::unexpected(IoError("create", partial, error.value()));
  SnapshotReport report;
  Status done = Fill(state, spec, extents, partial, report);
  if (done) done = SyncDirectory(partial);
  if (done && rename(partial.c_str(), directory.c_str()) != 0) {
    done = tl::unexpected(IoError("rename", partial, errno));
  }
  if (!done) {
    fs::remove_all(partial, error);
    return tl::unexpected(std::move(done.error()));
  }
  DADRL_RETURN_IF_ERROR(SyncDirectory(directory.parent_path()));
  return report;
}

}  // namespace dadrl
