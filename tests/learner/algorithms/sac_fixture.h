// Batches and state access for the tests of SAC.
#pragma once

#include <cstring>
#include <memory>

#include "learner/algorithms/sac.h"
#include "tests/driving_columns.h"
#include "tests/golden/golden.h"
#include "tests/learner/algorithms/state_blocks.h"

namespace dadrl {

// Hands out prepared draws in the order in which they are asked for.
class RecordedNoise final : public NoiseSource {
 public:
  void Push(std::vector<float> values) { draws_.insert(draws_.end(), values.begin(), values.end()); }
  void Fill(std::span<float> values) override {
    ASSERT_LE(next_ + values.size(), draws_.size());
    std::copy_n(draws_.begin() + static_cast<ptrdiff_t>(next_), values.size(), values.begin());
    next_ += values.size();
  }
  std::span<std::byte> state() override { return std::as_writable_bytes(std::span(&next_, 1)); }

 private:
  std::vector<float> draws_;
  size_t next_ = 0;
};

// Transitions that own what they show.
struct TransitionBatch {
  TransitionBatch(const DrivingShape& spec, int size)
      : observation(spec, size),
        next_observation(spec, size),
        action(static_cast<size_t>(size) * kActionSize),
        reward(static_cast<size_t>(size)),
        discount(static_cast<size_t>(size)),
        weight(static_cast<size_t>(size), 1.0f) {}
  operator Transitions() const { return {observation, next_observation, action, reward, discount, weight}; }

  Columns observation;
  Columns next_observation;
  std::vector<float> action, reward, discount, weight;
};

// Any batch: plausible values, some absent vehicles, a termination; the same for the same salt.
inline TransitionBatch AnyBatch(const DrivingShape& spec, int size, uint64_t salt) {
  TransitionBatch batch(spec, size);
  const auto fill = [&](std::span<float> values, float scale) {
    std::ranges::copy(golden::Uniform(salt++, values.size(), scale), values.begin());
  };
  for (Columns* observation : {&batch.observation, &batch.next_observation}) {
    fill(VehiclesOf(*observation), 1.0f);
    fill(EgoOf(*observation), 1.0f);
    const std::vector<float> bits = golden::Uniform(salt++, ContextOf(*observation).size(), 128.0f);
    std::ranges::transform(bits, ContextOf(*observation).begin(),
                           [](float value) { return static_cast<uint8_t>(value + 128.0f); });
  }
  fill(batch.action, 0.99f);
  fill(batch.reward, 1.0f);
  std::ranges::fill(batch.discount, 0.99f);
  batch.discount.front() = 0.0f;
  return batch;
}

// Of the last update.
inline double ScalarOf(const Algorithm& algorithm, std::string_view name) {
  const auto specs = algorithm.spec().scalars;
  const auto found = std::ranges::find(specs, name, &ScalarSpec::name);
  if (found != specs.end()) return algorithm.scalars()[static_cast<size_t>(found - specs.begin())];
  ADD_FAILURE() << "no scalar " << name;
  return 0.0;
}

}  // namespace dadrl
