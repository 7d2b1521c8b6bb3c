// Experience in: chunks from actors into the table, acknowledgements back.
#pragma once

#include <atomic>
#include <functional>
#include <memory>

#include "common/config/config.h"
#include "common/port/port.h"
#include "common/util/clock.h"
#include "common/util/result.h"
#include "common/util/time_ledger.h"
#include "proto/topics.h"
#include "replay/service/acknowledger.h"
#include "replay/table.h"

namespace dadrl {

// The table's one inserting thread runs Run, a WorkingThread, or calls Step; ledger and Wake are for any.
//
// What an acknowledgement promises is replay.sync: always - the chunk is on the device; interval - it
// survives the death of every process, and reaches the device within replay.sync_interval_s; none - as
// interval, but when the system sees fit.
//
// A full disk (any failing write) is said once, stops acknowledgements, and is tried again with each chunk
// that actors repeat, at most every kRetryInterval: sampling goes on meanwhile.
class Ingest {
 public:
  static constexpr Duration kRetryInterval = std::chrono::milliseconds(250);

  // Borrows `table` and `clock`. `on_insert` is called after chunks were stored: samplers may be waiting.
  static Result<std::unique_ptr<Ingest>> Create(const Transport& transport, const Config& config,
                                                uint32_t shard, ReplayTable& table, const Clock& clock,
                                                std::function<void()> on_insert);

  // Takes what is here and answers; waits a little for more when there was nothing.
  void Step();
  // Steps until `stop`; then takes what has arrived, and says so to the actors.
  void Run(const std::atomic<bool>& stop);
  // Looks again at what the limiter grants: a batch was sampled. Cheap when it withholds nothing.
  void Wake();
  // Work, and waits for the disk and for samples.
  const TimeLedger& ledger() const { return ledger_; }

 private:
  using ChunkReader = Reader<dadrl_idl_ChunkMessage>;
  Ingest(std::unique_ptr<ChunkReader> reader, std::unique_ptr<Acknowledger> acknowledger,
         const ReplayConfig& replay, ReplayTable& table, const Clock& clock, std::function<void()> on_insert);
  int TakeChunks();
  void OnChunk(const dadrl_idl_ChunkMessage& message);
  void OnFailure(const Error& error);
  void OnSuccess();
  // Makes good what `replay.sync` promises before an acknowledgement leaves; false: not possible now.
  bool SyncIfPromised();
  Acknowledger::Grant CurrentGrant();

  const std::unique_ptr<ChunkReader> reader_;
  const std::unique_ptr<Acknowledger> acknowledger_;
  const ReplayConfig replay_;
  ReplayTable& table_;
  const Clock& clock_;
  const std::function<void()> on_insert_;
  TimeLedger ledger_;

  std::atomic<bool> withholding_{false};
  uint64_t stored_ = 0;   // chunks, by this process
  bool failing_ = false;  // the last write to the disk failed
  TimePoint retry_at_{};
  bool unsynced_ = false;
};

}  // namespace dadrl
