#include "replay/service/maintenance.h"

#include <utility>

#include "common/liveness/working_thread.h"
#include "common/util/fault.h"
#include "common/util/log.h"
#include "replay/storage/snapshot_folder.h"

namespace dadrl {
namespace {

constexpr Duration kWait = std::chrono::milliseconds(20);
// What a disk may take for a snapshot before the process is taken to hang.
constexpr Duration kSlowDisk = std::chrono::minutes(10);
constexpr Duration kTidyInterval = std::chrono::seconds(1);
constexpr Duration kSnapshotCheckInterval = std::chrono::seconds(10);

}  // namespace

Maintenance::Maintenance(const ReplayConfig& replay, uint32_t shard,
                         const std::filesystem::path& run_directory, ReplayTable& table, const Clock& clock)
    : replay_(replay),
      shard_(shard),
      snapshots_(SnapshotFolder(run_directory, shard)),
      table_(table),
      clock_(clock),
      tasks_(clock, ProcessFaults()) {
  if (const Status removed = RemovePartialSnapshots(snapshots_); !removed) {
    spdlog::warn("{}", removed.error().message);
  }
  const TimePoint now = clock.Now();
  const auto every = [&](Duration interval, FaultKind fault, std::function<Status()> work) {
    if (interval > Duration::zero()) tasks_.Add(interval, now + interval, fault, std::move(work));
  };
  if (replay_.sync == SyncMode::kInterval) {
    every(FromSeconds(replay_.sync_interval_s), FaultKind::kSync, [this] { return table_.Sync(); });
  }
  every(FromSeconds(replay_.state_interval_s), FaultKind::kState, [this] { return table_.SaveState(); });
  every(kWait, FaultKind::kState, [this] { return table_.SaveStateOfNewSegment(); });
  every(FromSeconds(replay_.snapshot_interval_s), FaultKind::kSnapshot,
        [this] { return TakeAutomaticSnapshot(); });
  every(kTidyInterval, FaultKind::kDamage, [this] { return table_.TrimMemory(), table_.DropDamaged(); });
  // The first time at once: snapshots outlive the process that took them.
  tasks_.Add(kSnapshotCheckInterval, now, FaultKind::kSnapshotSpace, [this] { return CheckSnapshots(); });
}

void Maintenance::Run(const std::atomic<bool>& stop) {
  const WorkingThread working("maintain");
  while (!stop.load()) {
    const auto job = jobs_.Pop(kWait);
    const LongWork on_disk(kSlowDisk);
    if (job) DoJob(*job);
    tasks_.RunDue();
  }
}

bool Maintenance::Do(uint64_t job, std::function<Result<std::string>()> work) {
  Job handed{.id = job, .work = std::move(work)};
  return jobs_.TryPush(handed);
}

void Maintenance::DoJob(const Job& job) {
  // With so many outcomes that nobody took, nobody waits for this one.
  done_.PushOrDrop({.job = job.id, .outcome = job.work()});
}

Result<std::string> Maintenance::TakeSnapshot(const std::string& name) {
  DADRL_RETURN_IF_ERROR(CheckSnapshotName(name));
  DADRL_ASSIGN_OR_RETURN(const SnapshotReport report, table_.Snapshot(snapshots_ / name));
  const SnapshotUse use = UseOfSnapshots(snapshots_, table_.directory());
  return fmt::format(
      "shard {}: snapshot {} of {:.1f} MB, {:.1f} MB of them copied; {} snapshots hold {:.1f} MB in files of "
      "their own",
      shard_, (snapshots_ / name).string(), report.bytes / 1e6, report.copied_bytes / 1e6, use.snapshots,
      use.bytes / 1e6);
}

Status Maintenance::CheckSnapshots() {
  const SnapshotUse use = UseOfSnapshots(snapshots_, table_.directory());
  snapshot_bytes_.store(use.bytes);
  if (use.bytes <= static_cast<uint64_t>(replay_.max_disk_bytes)) return {};
  return Fail(
      ErrorCode::kExhausted,
      "shard {}: {} snapshots hold {} bytes that the replay has dropped, more than its own "
      "replay.max_disk_bytes of {}; remove those you do not need from {}, or keep fewer automatic ones "
      "(replay.snapshots_kept, now {})",
      shard_, use.snapshots, use.bytes, replay_.max_disk_bytes, snapshots_.string(), replay_.snapshots_kept);
}

Status Maintenance::TakeAutomaticSnapshot() {
  DADRL_ASSIGN_OR_RETURN(const std::string said,
                         TakeSnapshot(NextSnapshotName(snapshots_, clock_.WallTimeNs())));
  spdlog::info("{}", said);
  return RemoveOldSnapshots(snapshots_, replay_.snapshots_kept);
}

}  // namespace dadrl
