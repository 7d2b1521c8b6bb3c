// The one random generator: small, fast, the same bits on every machine, its state savable in a checkpoint.
#pragma once

#include <array>
#include <cstdint>

namespace dadrl {

// xoshiro256++ (Blackman and Vigna, 2019), seeded through splitmix64. Not thread safe: one a thread.
class Random {
 public:
  // Everything the generator is; equal states give equal draws.
  struct State {
    std::array<uint64_t, 4> words{};
    bool operator==(const State&) const = default;
  };

  explicit Random(uint64_t seed);
  explicit Random(const State& state) : state_(state) {}

  uint64_t Next();
  // In [0, 1).
  double Uniform();
  // In [low, high).
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  // In [0, bound), without modulo bias; bound >= 1.
  uint64_t Below(uint64_t bound);
  // Standard normal (Box-Muller, both halves drawn fresh so that State stays complete).
  double Normal();

  const State& state() const { return state_; }

 private:
  State state_;
};

// An independent seed for part `index` of a thing seeded with `seed` (an actor of a run, a type of an
// episode).
uint64_t DeriveSeed(uint64_t seed, uint64_t index);

}  // namespace dadrl
