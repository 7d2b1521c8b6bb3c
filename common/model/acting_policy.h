// The policy as an actor uses it: one observation, one core, tens of microseconds.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/config/config.h"
#include "common/step/driving_shape.h"
#include "common/step/observation.h"
#include "common/util/random.h"
#include "common/util/result.h"

namespace dadrl {

// Networks of the policy (encoder and head), single-observation path. Agrees with the batched path to 1e-5.
// Not thread safe; owns all its memory, allocates nothing in Act.
class ActingPolicy {
 public:
  ActingPolicy(const DrivingShape& spec, const ModelConfig& model);
  ~ActingPolicy();
  ActingPolicy(ActingPolicy&&) noexcept;
  ActingPolicy& operator=(ActingPolicy&&) noexcept;

  // Length and hash of the flat parameter vector; a broadcast or checkpoint with another hash is refused.
  size_t parameter_count() const;
  uint64_t layout_hash() const;

  // Copies and pre-packs the parameters. kInvalidArgument when the length is wrong, kCorrupt when one is not
  // finite.
  Status Load(std::span<const float> parameters);

  // tanh(mean + exp(log_std) * noise) with noise from `random`; tanh(mean) when `random` is null.
  // Requires a Load; the observation must fit the spec.
  Action Act(const Observation& observation, Random* random);

  // Of the last Act.
  struct Details {
    Action mean{};     // before tanh
    Action log_std{};  // clamped
    std::vector<float>
        attention;  // [vehicles], sums to at most 1 (the rest is the zero slot); empty without STAE
  };
  const Details& last() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dadrl
