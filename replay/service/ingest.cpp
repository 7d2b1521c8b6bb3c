#include "replay/service/ingest.h"

#include <span>
#include <utility>

#include "common/liveness/working_thread.h"
#include "common/util/fault.h"

namespace dadrl {
namespace {

// Chunks between two rounds of acknowledgements.
constexpr int kRound = 32;
constexpr Duration kIdleWait = std::chrono::milliseconds(50);
// What a disk may take for one write before the process is taken to hang.
constexpr Duration kSlowDisk = std::chrono::minutes(1);
// What an actor may have under way, where few share the reader: enough to fill the pipe, or, where the
// limiter holds actors back, little enough for it to hold them back soon.
constexpr uint64_t kWideWindow = 64;
constexpr uint64_t kNarrowWindow = 2;

}  // namespace

Result<std::unique_ptr<Ingest>> Ingest::Create(const Transport& transport, const Config& config,
                                               uint32_t shard, ReplayTable& table, const Clock& clock,
                                               std::function<void()> on_insert) {
  // The writer first: an actor that finds the reader can already be answered.
  DADRL_ASSIGN_OR_RETURN(auto acknowledger, Acknowledger::Create(transport, shard));
  DADRL_ASSIGN_OR_RETURN(auto reader, ChunkReader::Create(transport, ChunkTopic(static_cast<int>(shard))));
  return std::unique_ptr<Ingest>(new Ingest(std::move(reader), std::move(acknowledger), config.replay, table,
                                            clock, std::move(on_insert)));
}

Ingest::Ingest(std::unique_ptr<ChunkReader> reader, std::unique_ptr<Acknowledger> acknowledger,
               const ReplayConfig& replay, ReplayTable& table, const Clock& clock,
               std::function<void()> on_insert)
    : reader_(std::move(reader)),
      acknowledger_(std::move(acknowledger)),
      replay_(replay),
      table_(table),
      clock_(clock),
      on_insert_(std::move(on_insert)),
      ledger_(clock) {
  for (const SequenceTable::Stream& stream : table_.Streams()) acknowledger_->Note(stream);
}

void Ingest::Step() {
  const int taken = TakeChunks();
  acknowledger_->SetGrant(CurrentGrant());
  const bool more_due = SyncIfPromised() && acknowledger_->Publish(clock_.Now());
  if (taken == 0) reader_->Wait(more_due ? Acknowledger::kMinInterval : kIdleWait);
}

void Ingest::Run(const std::atomic<bool>& stop) {
  const WorkingThread working("ingest");
  while (!stop.load()) {
    Beat();
    Step();
  }
  while (TakeChunks() > 0) {
  }
  if (SyncIfPromised()) acknowledger_->Publish(clock_.Now() + Acknowledger::kMinInterval);
}

void Ingest::Wake() {
  if (withholding_.load()) reader_->Wake();
}

int Ingest::TakeChunks() {
  const int taken =
      reader_->Take(kRound, [this](const dadrl_idl_ChunkMessage& message) { OnChunk(message); });
  if (taken > 0) on_insert_();
  return taken;
}

void Ingest::OnChunk(const dadrl_idl_ChunkMessage& message) {
  // While writes fail, what arrives is dropped unseen: the actors keep it and send it again.
  if (failing_ && clock_.Now() < retry_at_) return;
  const std::span bytes(reinterpret_cast<const std::byte*>(message.bytes._buffer), message.bytes._length);
  const LongWork storing(kSlowDisk);
  ChunkRefusal refusal;
  const Result<ReplayTable::Insertion> inserted = table_.Insert(bytes, message.oldest_kept, &refusal);
  if (!inserted) {
    OnFailure(inserted.error());
    return;
  }
  if (*inserted == ReplayTable::Insertion::kStored) {
    unsynced_ = true;
    ReportWork(++stored_);
    // What is promised to be on the device must get there as well.
    if (replay_.sync != SyncMode::kAlways) OnSuccess();
  }
  const ChunkIdentity identity{message.actor, message.incarnation, message.chunk_sequence};
  const bool refused = *inserted == ReplayTable::Insertion::kRejected;
  if (refused && identity.sequence > 0) table_.Settle(identity, message.oldest_kept);
  if (const auto stream = table_.StreamOf(message.actor)) {
    acknowledger_->Note(*stream);
    acknowledger_->Hear(message.actor, clock_.Now());
  }
  if (refused && identity.sequence > 0) acknowledger_->Refuse(identity, refusal);
}

void Ingest::OnFailure(const Error& error) {
  retry_at_ = clock_.Now() + kRetryInterval;
  failing_ = true;
  ProcessFaults().Report(FaultKind::kExperience, tl::unexpected(error));
}

void Ingest::OnSuccess() {
  if (std::exchange(failing_, false)) ProcessFaults().Report(FaultKind::kExperience, {});
}

bool Ingest::SyncIfPromised() {
  if (replay_.sync != SyncMode::kAlways || !unsynced_) return true;
  if (failing_ && clock_.Now() < retry_at_) return false;
  const LongWork forcing(kSlowDisk);
  ScopedActivity waiting(ledger_, Activity::kWaitForDisk);
  if (const Status synced = table_.Sync(); !synced) {
    OnFailure(synced.error());
    return false;
  }
  unsynced_ = false;
  OnSuccess();
  return true;
}

Acknowledger::Grant Ingest::CurrentGrant() {
  // One chunk, so that an actor's repeats tell when there is room again.
  if (failing_) {
    ledger_.Enter(Activity::kWaitForDisk);
    return {1};
  }
  // Before the look, so that a sample after it wakes us.
  withholding_.store(true);
  if (!table_.MayInsert()) {
    ledger_.Enter(Activity::kWaitForSamples);
    return {0};
  }
  withholding_.store(false);
  ledger_.Enter(Activity::kWork);
  const uint64_t window = replay_.min_samples_per_insert > 0.0 ? kNarrowWindow : kWideWindow;
  return {acknowledger_->Share(window, clock_.Now())};
}

}  // namespace dadrl
