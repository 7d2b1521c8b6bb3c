// Batches from a generator in the same process: what a test trains on.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "common/model/transition_batch.h"
#include "common/util/random.h"
#include "learner/batch_source.h"

namespace dadrl {

// Batch number i depends on i and the seed alone; starts at `first`. Gives `available` of them, then none.
class MemoryBatchSource final : public BatchSource<TransitionBatch> {
 public:
  explicit MemoryBatchSource(int batch_size, uint64_t first = 0)
      : batch_(ObservationSpec{}, batch_size), next_(first) {}

  TransitionBatch* Take(Duration) override {
    if (available == 0) return nullptr;
    --available;
    Random random(DeriveSeed(11, next_++));
    for (float& reward : batch_.reward) reward = static_cast<float>(random.Uniform(-1.0, 1.0));
    for (float& x : batch_.observation.vehicles) x = static_cast<float>(random.Uniform(-1.0, 1.0));
    for (float& x : batch_.observation.ego) x = static_cast<float>(random.Uniform(-1.0, 1.0));
    for (float& x : batch_.next_observation.vehicles) x = static_cast<float>(random.Uniform(-1.0, 1.0));
    for (float& x : batch_.next_observation.ego) x = static_cast<float>(random.Uniform(-1.0, 1.0));
    for (float& x : batch_.action) x = static_cast<float>(random.Uniform(-0.9, 0.9));
    for (uint8_t& bits : batch_.observation.context) bits = static_cast<uint8_t>(random.Next());
    for (uint8_t& bits : batch_.next_observation.context) bits = static_cast<uint8_t>(random.Next());
    batch_.discount.assign(batch_.discount.size(), 0.99f);
    batch_.policy_version.assign(batch_.policy_version.size(), acting_version);
    if (poisoned) batch_.reward[0] = std::nanf("");
    ++lent;
    return &batch_;
  }
  void Release(TransitionBatch*) override { --lent; }
  void UpdatePriorities(const TransitionBatch&, std::span<const float> td_error) override {
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
  TransitionBatch batch_;
  uint64_t next_;
};

}  // namespace dadrl
