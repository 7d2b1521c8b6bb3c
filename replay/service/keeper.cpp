#include "replay/service/keeper.h"

#include <algorithm>
#include <utility>

#include "common/util/log.h"
#include "replay/service/limit_command.h"
#include "replay/storage/snapshot_folder.h"

namespace dadrl {
namespace {

constexpr Duration kWait = std::chrono::milliseconds(20);
constexpr Duration kTrimInterval = std::chrono::seconds(1);
constexpr Duration kSnapshotCheckInterval = std::chrono::seconds(10);

}  // namespace

Result<std::unique_ptr<Keeper>> Keeper::Create(const dds::Node& node, const Config& config, uint32_t shard,
                                               const std::filesystem::path& run_directory, ReplayTable& table,
                                               const Clock& clock, std::function<void()> on_limit) {
  if (const Status removed = RemovePartialSnapshots(SnapshotFolder(run_directory, shard)); !removed) {
    spdlog::warn("{}", removed.error().message);
  }
  // The writer first: who finds the reader can already be answered.
  DADRL_ASSIGN_OR_RETURN(auto answers, AnswerWriter::Create(node, kReplayAnswerTopic));
  DADRL_ASSIGN_OR_RETURN(auto commands, CommandReader::Create(node, kReplayCommandTopic));
  return std::unique_ptr<Keeper>(new Keeper(std::move(commands), std::move(answers), config, shard,
                                            run_directory, table, clock, std::move(on_limit)));
}

Keeper::Keeper(std::unique_ptr<CommandReader> commands, std::unique_ptr<AnswerWriter> answers,
               const Config& config, uint32_t shard, const std::filesystem::path& run_directory,
               ReplayTable& table, const Clock& clock, std::function<void()> on_limit)
    : commands_(std::move(commands)),
      answers_(std::move(answers)),
      replay_(config.replay),
      shard_(shard),
      snapshots_(SnapshotFolder(run_directory, shard)),
      table_(table),
      on_limit_(std::move(on_limit)),
      chores_(clock) {
  const TimePoint now = clock.Now();
  const auto every = [&](Duration interval, std::function<Status()> work) {
    if (interval > Duration::zero()) chores_.Add(interval, now + interval, std::move(work));
  };
  if (replay_.sync == SyncMode::kInterval) {
    every(FromSeconds(replay_.sync_interval_s), [this] { return table_.Sync(); });
  }
  every(FromSeconds(replay_.state_interval_s), [this] { return table_.SaveState(); });
  every(kWait, [this] { return table_.SaveStateOfNewSegment(); });
  every(FromSeconds(replay_.snapshot_interval_s), [this] { return TakeAutomaticSnapshot(); });
  every(kTrimInterval, [this] { return table_.TrimMemory(), Status(); });
  // The first time at once: snapshots outlive the process that took them.
  chores_.Add(kSnapshotCheckInterval, now, [this] { return CheckSnapshots(); });
}

void Keeper::Run(const std::atomic<bool>& stop) {
  while (!stop.load()) {
    commands_->Wait(kWait);
    commands_->Take(8, [this](const dadrl_idl_ReplayCommand& command) { OnCommand(command); });
    chores_.DoDue();
  }
}

void Keeper::OnCommand(const dadrl_idl_ReplayCommand& command) {
  if (command.shard != shard_) return;
  if (command.command != last_command_) {
    const Result<std::string> done = Obey(command);
    last_command_ = command.command;
    last_done_ = done.has_value();
    last_text_ = done ? *done : done.error().message;
    if (done) {
      spdlog::info("{}", last_text_);
    } else {
      spdlog::warn("{}", last_text_);
    }
  }
  dadrl_idl_ReplayAnswer answer{};
  answer.shard = shard_;
  answer.command = last_command_;
  answer.done = last_done_;
  const size_t length = std::min(last_text_.size(), sizeof(answer.text) - 1);  // ends with a zero
  std::copy_n(last_text_.data(), length, answer.text);
  if (const Status sent = answers_->Write(answer); !sent) spdlog::warn("answer: {}", sent.error().message);
}

Result<std::string> Keeper::Obey(const dadrl_idl_ReplayCommand& command) {
  switch (static_cast<ReplayCommandKind>(command.kind)) {
    case ReplayCommandKind::kLimit:
      return ChangeLimit(command);
    case ReplayCommandKind::kSnapshot:
      return TakeSnapshot(command.snapshot);
  }
  return Fail(ErrorCode::kInvalidArgument, "shard {} does not know command {}", shard_, command.kind);
}

Result<std::string> Keeper::ChangeLimit(const dadrl_idl_ReplayCommand& command) {
  Result<RateLimiter::Options> changed = ChangedLimits(table_.limiter_options(), command);
  if (!changed) return Fail(ErrorCode::kInvalidArgument, "shard {}: {}", shard_, changed.error().message);
  const RateLimiter::Options& options = *changed;
  table_.Reconfigure(options);
  on_limit_();
  DADRL_RETURN_IF_ERROR(table_.SaveState());
  return fmt::format(
      "shard {}: at most {} and at least {} samples per insert, from {} frames on, band {} frames", shard_,
      options.max_samples_per_insert, options.min_samples_per_insert, options.min_size, options.band);
}

Result<std::string> Keeper::TakeSnapshot(const std::string& name) {
  DADRL_RETURN_IF_ERROR(CheckSnapshotName(name));
  DADRL_ASSIGN_OR_RETURN(const SnapshotReport report, table_.Snapshot(snapshots_ / name));
  const SnapshotUse use = UseOfSnapshots(snapshots_, table_.directory());
  return fmt::format(
      "shard {}: snapshot {} of {:.1f} MB, {:.1f} MB of them copied; {} snapshots hold {:.1f} MB in files of "
      "their own",
      shard_, (snapshots_ / name).string(), static_cast<double>(report.bytes) / 1e6,
      static_cast<double>(report.copied_bytes) / 1e6, use.snapshots, static_cast<double>(use.bytes) / 1e6);
}

Status Keeper::CheckSnapshots() {
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

Status Keeper::TakeAutomaticSnapshot() {
  DADRL_ASSIGN_OR_RETURN(const std::string said, TakeSnapshot(AutomaticSnapshotName(WallTimeNs())));
  spdlog::info("{}", said);
  return RemoveOldSnapshots(snapshots_, replay_.snapshots_kept);
}

}  // namespace dadrl
