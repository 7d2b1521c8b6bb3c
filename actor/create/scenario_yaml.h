// A scenario as the text of its scenario.yaml.
#pragma once

#include <string>

#include "actor/sim/scenario.h"

namespace dadrl {

// With a first line for the reader, which has no line breaks, and the two traffic profiles of the scenarios
// that ship. LoadScenario reads it back.
std::string ScenarioYaml(const Scenario& scenario, const std::string& first_line);

}  // namespace dadrl
