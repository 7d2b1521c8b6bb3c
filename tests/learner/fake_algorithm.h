// A learning algorithm of a few numbers: its state depends on every batch, on the order of batches and on its
// random generator, so that a resume that forgets anything shows in the bits. It reports scalars that no
// other algorithm has; the second of them in every other update.
#pragma once

#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "common/util/random.h"
#include "learner/algorithms/algorithm.h"

namespace dadrl {

class FakeAlgorithm final : public Algorithm {
 public:
  explicit FakeAlgorithm(size_t parameters = 200, uint64_t seed = 3)
      : policy_(parameters, 0.1f), moment_(parameters, 0.0f), random_(Random(seed).state()) {}

  static constexpr std::array kScalars = {ScalarSpec{"fit", "loss/fit", ScalarKind::kSquaredError},
                                          ScalarSpec{"halting", "toy/halting"}};

  const AlgorithmSpec& spec() const override { return spec_; }
  Status Update(const TrajectoryBatch& batch) override {
    if (fail_at_ != 0 && updates_ + 1 == fail_at_) {
      return Fail(ErrorCode::kInternal, "fit is not finite (nan) in update {}", fail_at_);
    }
    ++updates_;
    Random random(random_);
    double loss = 0.0;
    for (size_t i = 0; i < policy_.size(); ++i) {
      const size_t row = i % static_cast<size_t>(batch.shape.count);
      const float gradient = batch.rewards[row] + 0.01f * static_cast<float>(random.Normal());
      moment_[i] = 0.9f * moment_[i] + 0.1f * gradient;
      policy_[i] += 0.001f * moment_[i] / (1.0f + static_cast<float>(updates_));
      loss += gradient * gradient;
    }
    random_ = random.state();
    if (spec_.gives_priorities) {
      priorities_.assign(static_cast<size_t>(batch.shape.count), static_cast<float>(updates_));
    }
    if (updates_ == run_away_at_) loss = 1e57;
    scalars_ = {loss, updates_ % 2 == 0 ? static_cast<double>(updates_) : std::nan("")};
    return {};
  }
  std::span<const double> scalars() const override { return scalars_; }
  std::span<const float> priorities() const override { return priorities_; }
  std::vector<NamedNetwork> networks() const override { return {{kPolicyNetwork, 0xfa4e, policy_}}; }
  std::vector<StateBlock> state() override {
    return {{"policy", std::as_writable_bytes(std::span(policy_))},
            {"moment", std::as_writable_bytes(std::span(moment_))},
            {"updates", std::as_writable_bytes(std::span(&updates_, 1))},
            {"random", std::as_writable_bytes(std::span(&random_, 1))}};
  }

  void GiveNoPriorities() { spec_.gives_priorities = false; }
  void ActFromStart() { spec_.acts_from_start = true; }
  // The update of this number (counted from 1) fails as one with a NaN does.
  void FailAt(uint64_t update) { fail_at_ = update; }
  // The update of this number reports a loss that no rewards account for.
  void RunAwayAt(uint64_t update) { run_away_at_ = update; }
  // A weight goes bad without the loss showing it.
  void SpoilPolicy() { policy_[7] = std::nanf(""); }

 private:
  AlgorithmSpec spec_{
      .batch = {.count = 16}, .scalars = kScalars, .gives_priorities = true, .acts_from_start = false};
  std::array<double, kScalars.size()> scalars_{};
  std::vector<float> policy_;
  std::vector<float> moment_;
  std::vector<float> priorities_;
  uint64_t updates_ = 0;
  Random::State random_;
  uint64_t fail_at_ = 0;
  uint64_t run_away_at_ = 0;
};

inline std::vector<std::byte> StateOf(Algorithm& algorithm) {
  std::vector<std::byte> bytes;
  for (const StateBlock& block : algorithm.state()) {
    bytes.insert(bytes.end(), block.bytes.begin(), block.bytes.end());
  }
  return bytes;
}

}  // namespace dadrl
