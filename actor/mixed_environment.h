// All scenarios as one environment: what `dadrl train all` learns from.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "actor/driving_environment.h"

namespace dadrl {

// Each episode is of the scenario that its seed draws, uniformly from all that are installed; the episode is
// the one that a DrivingEnvironment of that scenario starts from the same seed, whatever ran before. As
// Environment otherwise.
class MixedEnvironment final : public Environment {
 public:
  // Loads every scenario; errors as MakeDrivingEnvironment.
  static Result<std::unique_ptr<MixedEnvironment>> Create(const Config& config);

  // Which of `scenarios`, in [0, scenarios), the episode of `seed` is of.
  static size_t ScenarioOf(uint64_t seed, size_t scenarios);

  Status Reset(uint64_t seed) override;
  Result<StepResult> Step(const Action& action) override { return current_->Step(action); }
  const Observation& observation() const override { return current_->observation(); }
  const EpisodeSummary& summary() const override { return current_->summary(); }
  const DrivingEnvironment* driving() const override { return current_; }

 private:
  explicit MixedEnvironment(std::vector<std::unique_ptr<DrivingEnvironment>> environments)
      : environments_(std::move(environments)), current_(environments_.front().get()) {}

  const std::vector<std::unique_ptr<DrivingEnvironment>> environments_;  // at least one, by scenario name
  DrivingEnvironment* current_;
};

}  // namespace dadrl
