#include "deploy/cli/become.h"
#include "deploy/cli/command.h"

namespace dadrl {
namespace {

// dadrl-actor alone knows SUMO.
Result<int> RunScenario(std::vector<std::string> words) {
  words.insert(words.begin(), "scenario");
  return Become("dadrl-actor", std::move(words));
}

}  // namespace

Command MakeScenarioCommand(CLI::App& dadrl) {
  CLI::App* app =
      dadrl.add_subcommand("scenario", "Explain a scenario (check), or make one from a road network (new)");
  app->prefix_command();
  app->set_help_flag();  // its commands have their own
  return {app, [app] { return RunScenario(app->remaining()); }};
}

}  // namespace dadrl
