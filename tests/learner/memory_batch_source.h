// Batches from a generator in the same process: what a test trains on.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "common/step/driving_shape.h"
#include "common/step/trajectory_batch.h"
#include "common/util/random.h"
#include "learner/batch_source.h"

namespace dadrl {

// Batch number i depends on i and the seed alone; starts at `first`. Gives `available` of them, then none.
class MemoryBatchSource final : public BatchSource {
 public:
  explicit MemoryBatchSource(int batch_size, uint64_t first = 0)
      : batch_(DrivingShape{}, {.count = batch_size}), next_(first) {}

  TrajectoryBatch* Take(Duration) override {
    if (available == 0) return nullptr;
    --available;
    Random random(DeriveSeed(11, next_++));
    for (float& reward : batch_.rewards) reward = static_cast<float>(random.Uniform(-1.0, 1.0));
    for (size_t i = 0; i < batch_.observations.columns(); ++i) {
      for (float& x : batch_.observations.floats(i)) x = static_cast<float>(random.Uniform(-1.0, 1.0));
      for (uint8_t& bits : batch_.observations.bits(i)) bits = static_cast<uint8_t>(random.Next());
    }
    for (float& x : batch_.decisions[0]) x = static_cast<float>(random.Uniform(-0.9, 0.9));
    std::ranges::fill(batch_.steps, 1);
    std::ranges::fill(batch_.policy_versions, acting_version);
    if (poisoned) batch_.rewards[0] = std::nanf("");
    ++lent;
    return &batch_;
  }
  void Release(TrajectoryBatch*) override { --lent; }
  void UpdatePriorities(const TrajectoryBatch&, std::span<const float> td_error) override {
    priorities.assign(td_error.begin(), td_error.end());
  }
  Activity waiting_for() const override { return Activity::kWaitForInserts; }
  Status status() const override { return failure; }

  int available = 1 << 30;
  int lent = 0;
  bool poisoned = false;  // a reward of each batch is not a number
  uint32_t acting_version = 0;
  std::vector<float> priorities;
  Status failure;

 private:
  TrajectoryBatch batch_;
  uint64_t next_;
};

}  // namespace dadrl
