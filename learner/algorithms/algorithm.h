// What the learner process needs of a learning algorithm: each declares what it needs and reports, and the
// rest of the system asks for that, never for its name.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/model/named_network.h"
#include "common/step/trajectory_batch.h"
#include "common/util/result.h"
#include "learner/algorithms/scalar.h"

namespace dadrl {

// Fixed for an algorithm's life, and known from the configuration alone.
struct AlgorithmSpec {
  TrajectoryShape batch;                // what it trains on
  std::span<const ScalarSpec> scalars;  // of each update; of static storage
  bool gives_priorities = false;        // of the samples of each batch
  // It learns from what its own policy did alone: its untrained policy is published as version 1 before the
  // first update, and actors wait for it. Actors know of this by the configuration: the algorithm's preset
  // sets actor.wait_for_policy, and CheckNeeds (registry.h) refuses a configuration that says otherwise.
  // False: version 1 is the policy of the first update, and actors drive at random until it arrives.
  bool acts_from_start = false;
  bool trains_scene = false;  // has a loss of its own on the scene encoder: needs model.scene
  // It trains on each step once, and only on what its own policies of the last versions did: the replay is a
  // queue (replay.max_times_sampled 1) that drops what is too stale (replay.max_staleness) and holds actors
  // back in time (replay.min_samples_per_insert).
  bool on_policy = false;
  std::span<const std::string_view> decisions = {};  // decision columns that it reads beside the action
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

  virtual const AlgorithmSpec& spec() const = 0;

  // One training update, on a batch of spec().batch. Same state and batch give the same bits for a given
  // thread count. Errors are kInternal and name the tensor or loss that is not finite; the state is then
  // unusable: reload a checkpoint.
  virtual Status Update(const TrajectoryBatch& batch) = 0;
  // Of the last Update, in the order of spec().scalars; NaN: it had none. Valid until the next one.
  virtual std::span<const double> scalars() const = 0;
  // Of the last Update: [batch], not negative; empty unless spec().gives_priorities. Valid until the next
  // one.
  virtual std::span<const float> priorities() const = 0;

  // What policy files carry, valid until Update: the policy that actors use as kPolicyNetwork first (averaged
  // or current as configured), and whatever else there is to show of what was learnt.
  virtual std::vector<NamedNetwork> networks() const = 0;
  NamedNetwork published_policy() const { return networks().front(); }

  // Everything that a resumed training needs, in a fixed order: parameters, targets, optimiser moments,
  // temperature, counters, random state. Writing the bytes back restores it exactly.
  virtual std::vector<StateBlock> state() = 0;
};

}  // namespace dadrl
