// Experience on its way to a replay shard: chunks are kept until the replay has them.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

#include "actor/experience/backlog.h"
#include "actor/experience/chunking_sink.h"
#include "actor/experience/lease_holder.h"
#include "common/config/config.h"
#include "common/dds/node.h"
#include "common/port/port.h"
#include "common/util/mutex.h"
#include "proto/experience.h"
#include "proto/topics.h"

namespace dadrl {

// The ExperienceSink methods, Start and Flush belong to the simulation thread; the rest may be called by any,
// but for Step, which belongs to the sender thread. That one sends, repeats and hears acknowledgements, so
// nothing here waits for the network but Flush.
class ExperienceWriter final : public ChunkingSink {
 public:
  struct Statistics {
    uint64_t chunks = 0;        // produced
    uint64_t acknowledged = 0;  // of them
    uint64_t granted = 0;       // sequence up to which the replay takes chunks
    uint64_t resent = 0;        // chunks sent more than once
    uint64_t refused = 0;       // chunks that the replay will never take: dropped
    uint64_t invalid_acknowledgements = 0;
    int64_t backlog_bytes = 0;
    bool replay_present = false;
  };

  // Writes to shard `actor` mod `shards`. `incarnation` grows with each start of this actor. Borrows
  // `transport`, `clock` and `lease`, if there is one: the sender thread shows it, and once it is lost
  // nothing is sent any more.
  static Result<std::unique_ptr<ExperienceWriter>> Create(const Transport& transport, const Config& config,
                                                          uint32_t actor, uint64_t incarnation,
                                                          const Clock& clock, LeaseHolder* lease = nullptr);
  // Loses what is not acknowledged: Flush first.
  ~ExperienceWriter() override;

  // Calls Step on a thread of its own from now on.
  void Start();
  // Hears and sends what it can, then waits a little for more to do.
  void Step();

  // True while the backlog holds actor.max_unacknowledged_bytes, or while a replay is there that has been
  // given kAhead chunks more than it granted.
  bool blocked() const override;

  // Waits until every chunk is acknowledged, at most `timeout`; false when some are not. Steps meanwhile if
  // it was not started.
  bool Flush(Duration timeout);

  Statistics statistics() const;
  // An error once the replay takes nothing of this actor any more and never will; then nothing blocks. All
  // else passes, and is waited for. kExhausted: another has its number. kCorrupt: another spoke under its
  // number, and a new incarnation is free of that.
  Status status() const;

  static constexpr uint64_t kAhead = 4;
  // A replay that acknowledges for so long what was never sent has heard another under this actor's name.
  static constexpr Duration kInvalidLimit = std::chrono::seconds(10);

 private:
  using ChunkWriter = Writer<dadrl_idl_ChunkMessage>;
  using AcknowledgementReader = Reader<dadrl_idl_Acknowledgement>;

  ExperienceWriter(const Config& config, uint32_t actor, uint64_t incarnation, const Clock& clock,
                   LeaseHolder* lease);
  void OnChunk(uint64_t sequence, std::vector<std::byte> bytes) override;
  void AwaitAcknowledgement(Duration timeout) DADRL_EXCLUDES(mutex_);
  // The rest runs on the sender thread.
  // False once the replay takes nothing of this actor any more.
  bool ShowLease();
  void TakeProduced();
  void TakeAcknowledgements();
  void OnAcknowledgement(const dadrl_idl_Acknowledgement& ack);
  void CountRefusals(const dadrl_idl_Acknowledgement& ack);
  void OnInvalid(const dadrl_idl_Acknowledgement& ack);
  void End(Status why);
  void NoticePeer();
  void SendOrWait();
  void Publish();

  const uint32_t actor_;
  const uint64_t incarnation_;
  LeaseHolder* const lease_;
  const uint32_t shard_;
  const int64_t max_backlog_bytes_;
  const Clock& clock_;

  mutable Mutex mutex_;
  CondVar acknowledged_changed_;
  std::vector<Backlog::Chunk> produced_ DADRL_GUARDED_BY(mutex_);
  Statistics statistics_ DADRL_GUARDED_BY(mutex_);
  Status status_ DADRL_GUARDED_BY(mutex_);

  // Sender thread.
  Backlog backlog_;
  uint64_t match_generation_ = 0;
  uint64_t invalid_acknowledgements_ = 0;
  TimePoint invalid_since_{};  // {}: the last acknowledgement was sane
  uint64_t refused_ = 0;
  uint64_t refused_there_ = 0;       // as the present replay counts them
  bool forgotten_reported_ = false;  // of the present replay
  std::unique_ptr<ChunkWriter> chunks_;
  std::unique_ptr<AcknowledgementReader> acknowledgements_;

  std::atomic<bool> stopping_{false};
  std::thread sender_;
};

}  // namespace dadrl
