#include "actor/mixed_environment.h"

#include <utility>

#include "actor/sim/scenario.h"
#include "common/util/random.h"

namespace dadrl {
namespace {

// Apart from the streams that the traffic draws from the same seed.
constexpr uint64_t kScenarioStream = 0x5ce0a210;

}  // namespace

Result<std::unique_ptr<MixedEnvironment>> MixedEnvironment::Create(const Config& config) {
  std::vector<std::unique_ptr<DrivingEnvironment>> environments;
  Config one = config;
  for (const std::string& name : ScenarioNames()) {
    one.scenario = name;
    DADRL_ASSIGN_OR_RETURN(environments.emplace_back(), DrivingEnvironment::Create(one));
  }
  if (environments.empty()) {
    return Fail(ErrorCode::kNotFound, "no scenario in {}; build the project or set DADRL_SCENARIOS",
                ScenarioDirectory().string());
  }
  return std::unique_ptr<MixedEnvironment>(new MixedEnvironment(std::move(environments)));
}

size_t MixedEnvironment::ScenarioOf(uint64_t seed, size_t scenarios) {
  return Random(DeriveSeed(seed, kScenarioStream)).Below(scenarios);
}

Status MixedEnvironment::Reset(uint64_t seed) {
  current_ = environments_[ScenarioOf(seed, environments_.size())].get();
  return current_->Reset(seed);
}

}  // namespace dadrl
