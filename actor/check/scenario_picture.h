// A scenario drawn before anybody has driven it.
#pragma once

#include <string>

#include "actor/driving_environment.h"
#include "actor/sim/scenario.h"

namespace dadrl {

// The roads around route and flows, north up, as SVG text: where the ego starts, its way and its goal, the
// flows, the vehicles as they are when the episode begins. `environment`: reset.
std::string ScenarioPicture(const DrivingEnvironment& environment, const Scenario& scenario);

}  // namespace dadrl
