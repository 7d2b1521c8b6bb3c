// `dadrl scenario ...`: for those who bring a road of their own.
#pragma once

namespace dadrl {

// argv[0] is "scenario", then one of its commands and its options. Returns the exit code.
int RunScenarioCommand(int argc, char** argv);

}  // namespace dadrl
