#include <memory>

#include "deploy/cli/become.h"
#include "deploy/cli/command.h"

namespace dadrl {

Command MakeAlgorithmsCommand(CLI::App& dadrl) {
  auto json = std::make_shared<bool>(false);
  CLI::App* app = dadrl.add_subcommand("algorithms", "List the learning algorithms, a description each");
  app->add_flag("--json", *json, "One JSON object on standard output: what each reports and needs, too");
  app->footer(
      "--set algorithm.name=NAME chooses one, and with it the preset NAME.yaml below --config and --set:\n"
      "dadrl config --set algorithm.name=NAME shows what that comes to.");
  // The learner alone knows them.
  return {app, [json] {
            return Become("dadrl-learner", *json ? std::vector<std::string>{"algorithms", "--json"}
                                                 : std::vector<std::string>{"algorithms"});
          }};
}

}  // namespace dadrl
