// Batches from the replay shards, fetched and decoded while the learner trains.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "common/config/config.h"
#include "common/dds/node.h"
#include "common/port/port.h"
#include "common/util/bounded_queue.h"
#include "common/util/clock.h"
#include "common/util/mutex.h"
#include "common/util/result.h"
#include "learner/batch_source.h"
#include "learner/priority_sender.h"
#include "learner/request_book.h"
#include "proto/topics.h"
#include "proto/trajectory_codec.h"

namespace dadrl {

// Cumulative, except what is of now.
struct FetchStats {
  uint64_t batches = 0;   // decoded
  uint64_t bytes = 0;     // of all replies to us
  uint64_t corrupt = 0;   // dropped: bytes that are no batch of ours
  uint64_t stale = 0;     // dropped: request unknown, given up or answered before
  uint64_t foreign = 0;   // dropped: addressed to another learner, or from a shard that does not exist
  uint64_t repeated = 0;  // requests sent again
  uint64_t given_up = 0;  // requests moved to another shard
  uint64_t dropped_priorities = 0;
  uint64_t frames_held = 0;      // by all shards, now, as is the following
  uint64_t frames_inserted = 0;  // since the run began
};

struct FetchOptions {
  Duration request_timeout = std::chrono::seconds(2);       // then a request is sent again, or elsewhere
  Duration corrupt_pause = std::chrono::milliseconds(100);  // before asking again after garbage
};

// Step asks, receives and decodes, once started on a thread of its own, which alone calls it then;
// learner.credits batches for each shard go round. Memory is allocated once. Take, Release, UpdatePriorities,
// waiting_for: the training thread; others: any.
class BatchFetcher final : public BatchSource {
 public:
  // Fetches batches of `shape`. `incarnation` tells this learner from the one before it. `newest_version` is
  // called by Step. Borrows `transport` and `clock`. kInvalidArgument: replays of this configuration do not
  // serve such batches.
  static Result<std::unique_ptr<BatchFetcher>> Create(const Transport& transport, const Config& config,
                                                      const TrajectoryShape& shape, uint64_t incarnation,
                                                      std::function<uint32_t()> newest_version,
                                                      const Clock& clock, const FetchOptions& options);
  ~BatchFetcher() override;

  // Steps on a thread of its own from now on, and sends priorities on another.
  void Start();
  // Sends what is due, waits a little for replies and takes them. Nothing once a shard refused.
  void Step();

  TrajectoryBatch* Take(Duration timeout) override;
  void Release(TrajectoryBatch* batch) override;
  void UpdatePriorities(const TrajectoryBatch& batch, std::span<const float> td_error) override;
  Activity waiting_for() const override { return waiting_for_.load(std::memory_order_relaxed); }
  // kInvalidArgument: a shard refuses to serve this learner, since their configurations differ.
  Status status() const override DADRL_EXCLUDES(mutex_);

  FetchStats stats() const;

 private:
  struct Slot {
    TrajectoryBatch batch;
    uint32_t shard = 0;
  };
  struct Endpoints {
    std::unique_ptr<Writer<dadrl_idl_BatchRequest>> requests;
    std::unique_ptr<Reader<dadrl_idl_BatchReply>> replies;
    std::unique_ptr<PrioritySender> priorities;
  };

  BatchFetcher(Endpoints endpoints, const Config& config, const TrajectoryShape& shape, uint64_t incarnation,
               std::function<uint32_t()> newest_version, const Clock& clock, const FetchOptions& options);
  void Fetch();
  Duration WaitTime() const;
  bool can_ask() const;
  void RepeatAfterRematch();
  void SendDue();
  void OnReply(const dadrl_idl_BatchReply& reply);
  void OnRefusal(const dadrl_idl_BatchReply& reply) DADRL_EXCLUDES(mutex_);
  void Decode(const dadrl_idl_BatchReply& reply);
  void DropCorrupt(const dadrl_idl_BatchReply& reply, const Error& error);
  void UpdateReasonToWait();
  Slot& SlotOf(const TrajectoryBatch& batch);

  const Endpoints endpoints_;
  const Config config_;
  const TrajectoryShape shape_;
  const uint64_t schema_;
  const uint64_t incarnation_;
  const std::function<uint32_t()> newest_version_;
  const FetchOptions options_;
  const Clock& clock_;
  std::vector<std::unique_ptr<Slot>> slots_;
  BoundedQueue<Slot*> ready_;
  BoundedQueue<Slot*> free_;
  std::atomic<Activity> waiting_for_{Activity::kWaitForReplay};
  std::atomic<bool> stopping_{false};
  mutable Mutex mutex_;
  Status status_ DADRL_GUARDED_BY(mutex_);

  // Step's.
  std::vector<uint64_t> inserted_;  // frames, by shard
  RequestBook book_;
  TrajectoryDecoder decoder_;
  uint64_t match_generation_ = 0;
  int matched_repliers_ = 0;
  TimePoint corrupt_logged_at_{};

  std::atomic<uint64_t> batches_{0}, bytes_{0}, corrupt_{0}, stale_{0}, foreign_{0}, repeated_{0},
      given_up_{0}, frames_held_{0}, frames_inserted_{0};
  std::thread thread_;
};

}  // namespace dadrl
