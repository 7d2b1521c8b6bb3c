#include "deploy/cli/become.h"
#include "deploy/cli/command.h"

namespace dadrl {
namespace {

// dadrl-replay alone knows how experience is stored.
Result<int> RunTool(std::vector<std::string> words) {
  words.insert(words.begin(), "tool");
  return Become("dadrl-replay", std::move(words));
}

}  // namespace

Command MakeReplayCommand(CLI::App& dadrl) {
  CLI::App* app = dadrl.add_subcommand(
      "replay",
      "Inspect, verify, export, import, snapshot or restore stored experience; limit a running replay");
  app->prefix_command();
  app->set_help_flag();  // the tools have their own
  return {app, [app] { return RunTool(app->remaining()); }};
}

}  // namespace dadrl
