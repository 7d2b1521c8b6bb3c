// What the learner process needs of a learning algorithm: SAC first, others beside it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/model/named_network.h"
#include "common/step/trajectory_batch.h"
#include "common/util/result.h"

namespace dadrl {

// Scalars of one update, for logs and telemetry.
struct UpdateStats {
  double critic_loss = 0.0;
  double actor_loss = 0.0;
  double temperature = 0.0;
  double temperature_loss = 0.0;
  double entropy = 0.0;  // estimate, -mean log pi
  double mean_q = 0.0;
  double mean_target = 0.0;
};

// A named span of the algorithm's state, saved and restored as raw bytes by the checkpoint.
struct StateBlock {
  std::string name;  // "policy", "critic.adam_m", "random", ...
  std::span<std::byte> bytes;
};

// Not thread safe: the training thread owns it.
class Algorithm {
 public:
  virtual ~Algorithm() = default;

  // What it trains on.
  virtual TrajectoryShape batch_shape() const = 0;

  // One training update, on a batch of that shape. Same state and batch give the same bits for a given thread
  // count. Errors are kInternal and name the tensor or loss that is not finite; the state is then unusable:
  // reload a checkpoint. `td_error` ([batch], |error| of the critics' mean) is valid until the next Update.
  virtual Result<UpdateStats> Update(const TrajectoryBatch& batch) = 0;
  virtual std::span<const float> td_error() const = 0;

  // The policy that actors use, flat (see ActingPolicy): averaged or current as configured. Valid until
  // Update.
  virtual std::span<const float> published_policy() const = 0;
  virtual uint64_t layout_hash() const = 0;
  // What policy files carry, valid until Update: the published policy as kPolicyNetwork first, and whatever
  // else there is to show of what was learnt.
  virtual std::vector<NamedNetwork> networks() const = 0;

  // Everything that a resumed training needs, in a fixed order: parameters, targets, optimiser moments,
  // temperature, counters, random state. Writing the bytes back restores it exactly.
  virtual std::vector<StateBlock> state() = 0;
};

// kInvalidArgument for an unknown algorithm.name.
Result<std::unique_ptr<Algorithm>> MakeAlgorithm(const Config& config);

}  // namespace dadrl
