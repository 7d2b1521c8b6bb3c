// The maintenance of a shard, on a thread of its own: whatever may block on the disk and must not hold up
// inserting or sampling.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "common/config/config.h"
#include "common/util/bounded_queue.h"
#include "common/util/clock.h"
#include "common/util/result.h"
#include "replay/service/periodic_tasks.h"
#include "replay/table.h"

namespace dadrl {

// One thread runs Run; Do, TakeDone and snapshot_bytes are for any other. Forces the log to the device
// (replay.sync: interval), saves the state, takes snapshots into <run directory>/snapshots/shard-K, says when
// these hold too much of the disk, trims resident memory, and does what it is given.
class Maintenance {
 public:
  // That may wait for their turn.
  static constexpr size_t kMaxJobs = 16;

  struct Done {
    uint64_t job = 0;
    Result<std::string> outcome;
  };

  // Borrows `table` and `clock`.
  Maintenance(const ReplayConfig& replay, uint32_t shard, const std::filesystem::path& run_directory,
              ReplayTable& table, const Clock& clock);

  void Run(const std::atomic<bool>& stop);
  // Hands over what may block on the disk; false when kMaxJobs wait already. Never blocks.
  bool Do(uint64_t job, std::function<Result<std::string>()> work);
  // What has been done since; never blocks.
  std::optional<Done> TakeDone() { return done_.Pop(Duration::zero()); }
  // On the thread of Run.
  Result<std::string> TakeSnapshot(const std::string& name);
  // Bytes that only snapshots hold, as last looked at; for any thread.
  uint64_t snapshot_bytes() const { return snapshot_bytes_.load(); }

 private:
  struct Job {
    uint64_t id = 0;
    std::function<Result<std::string>()> work;
  };
  void DoJob(const Job& job);
  Status TakeAutomaticSnapshot();
  // kExhausted when snapshots hold more than the replay itself may.
  Status CheckSnapshots();

  const ReplayConfig replay_;
  const uint32_t shard_;
  const std::filesystem::path snapshots_;
  ReplayTable& table_;
  const Clock& clock_;
  std::atomic<uint64_t> snapshot_bytes_{0};
  PeriodicTasks tasks_;
  BoundedQueue<Job> jobs_{kMaxJobs};
  BoundedQueue<Done> done_{2 * kMaxJobs};
};

}  // namespace dadrl
