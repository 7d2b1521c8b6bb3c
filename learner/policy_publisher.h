// Where new policies go: to the actors (WeightPublisher).
#pragma once

#include <cstdint>
#include <span>

namespace dadrl {

// One policy on its way out. `parameters` is borrowed for the call.
struct PolicyUpdate {
  uint32_t version = 0;  // 1, 2, 3, ...; grows over restarts of the learner
  uint64_t layout_hash = 0;
  std::span<const float> parameters;
};

// Called by the training thread only.
class PolicyPublisher {
 public:
  virtual ~PolicyPublisher() = default;
  // Copies the parameters; never waits for the network or a disk. An update that is overtaken by a newer one
  // before it left is dropped.
  virtual void Publish(const PolicyUpdate& update) = 0;
};

}  // namespace dadrl
