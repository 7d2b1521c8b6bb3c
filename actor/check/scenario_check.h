// Whether a scenario can be driven, and what it is: what `dadrl scenario check` prints, and what `train`,
// `evaluate` and `render` ask before anything starts.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "actor/check/scenario_report.h"
#include "actor/driving_environment.h"
#include "common/config/config.h"
#include "common/util/result.h"

namespace dadrl {

// A scenario that can be driven, and what there is to know about it.
struct CheckedScenario {
  Scenario scenario;
  std::unique_ptr<DrivingEnvironment> environment;
  uint64_t seed = 0;  // of the episode that was tried
  ScenarioReport report;
};

// Loads config.scenario from `directory`, starts an episode as every actor does, drives the first seconds of
// it. Takes what these take; the process must not have an environment yet. Errors as
// DrivingEnvironment::Create, each with place and remedy; kInvalidArgument too when no episode can start.
Result<CheckedScenario> CheckScenario(const Config& config,
                                      const std::filesystem::path& directory = ScenarioDirectory());

}  // namespace dadrl
