// Where a learning algorithm's random numbers come from: passed in, so that a test can replay another
// implementation's draws, and part of the checkpoint.
#pragma once

#include <cstddef>
#include <span>

#include "common/util/random.h"

namespace dadrl {

// Not thread safe.
class NoiseSource {
 public:
  virtual ~NoiseSource() = default;
  // Fills with independent standard normal draws. Allocates nothing.
  virtual void Fill(std::span<float> values) = 0;
  // Everything that decides the next draws; writing the bytes back restores it.
  virtual std::span<std::byte> state() = 0;
};

class GaussianNoise final : public NoiseSource {
 public:
  explicit GaussianNoise(uint64_t seed) : state_(Random(seed).state()) {}

  void Fill(std::span<float> values) override {
    Random random(state_);
    for (float& value : values) value = random.Normal();
    state_ = random.state();
  }
  std::span<std::byte> state() override { return std::as_writable_bytes(std::span(state_.words)); }

 private:
  Random::State state_;
};

}  // namespace dadrl
