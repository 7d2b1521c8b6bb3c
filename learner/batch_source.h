// Where a learner's batches come from: the replay shards (BatchFetcher).
#pragma once

#include <span>

#include "common/step/trajectory_batch.h"
#include "common/util/clock.h"
#include "common/util/result.h"
#include "common/util/time_ledger.h"

namespace dadrl {

// Called by the training thread only.
class BatchSource {
 public:
  virtual ~BatchSource() = default;

  // The next ready batch, lent until Release, one at a time; null when there is none within `timeout` (zero:
  // now).
  virtual TrajectoryBatch* Take(Duration timeout) = 0;
  // Gives a taken batch back; its memory is used again.
  virtual void Release(TrajectoryBatch* batch) = 0;

  // New priorities of a taken batch, before its Release: `td_error` is [batch], absolute. Never blocks;
  // may be dropped.
  virtual void UpdatePriorities(const TrajectoryBatch& batch, std::span<const float> td_error) = 0;

  // Why there is no batch now: kWaitForBatch (one is under way), kWaitForInserts (the replay withholds it),
  // kWaitForReplay (no replay is there).
  virtual Activity waiting_for() const = 0;
  // The failure after which no batch will come any more; it ends the training.
  virtual Status status() const = 0;
};

}  // namespace dadrl
