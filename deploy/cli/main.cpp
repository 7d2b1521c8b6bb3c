// `dadrl`: what a user types. Exit codes: 0 done, 1 failed, 2 wrong usage.
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "common/config/config_schema.h"
#include "common/util/environment.h"
#include "common/util/log.h"
#include "common/util/process_setup.h"
#include "deploy/cli/command.h"
#include "deploy/local/build_info.h"

namespace dadrl {
namespace {

constexpr int kWrongUsage = 2;

int ReportParseError(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
  fmt::print(stderr, "dadrl: {} (dadrl --help shows what there is)\n", error.what());
  return kWrongUsage;
}

// CLI11 takes an unknown command for a surplus argument; here it gets the nearest name.
bool RefuseUnknownCommand(int argc, char** argv, const std::vector<Command>& commands) {
  if (argc < 2 || argv[1][0] == '-') return false;
  std::vector<std::string> names;
  names.reserve(commands.size());
  for (const Command& command : commands) names.push_back(command.app->get_name());
  if (std::find(names.begin(), names.end(), argv[1]) != names.end()) return false;
  fmt::print(stderr, "dadrl: unknown command '{}'; the nearest is '{}' (there are: {})\n", argv[1],
             NearestName(argv[1], names), fmt::join(names, ", "));
  return true;
}

int Main(int argc, char** argv) {
  InitLogging("dadrl");
  CLI::App app("Trains a vehicle to drive through dense traffic, on one machine or many.", "dadrl");
  app.set_version_flag("--version", "dadrl " DADRL_VERSION " (" + BuildCommit() + ")");
  app.require_subcommand(1);
  const std::vector<Command> commands = {
      MakeTrainCommand(app),      MakeCollectCommand(app),  MakeEvaluateCommand(app),
      MakeSelectCommand(app),     MakeRenderCommand(app),   MakeMonitorCommand(app),
      MakeActorCommand(app),      MakeDoctorCommand(app),   MakeConfigCommand(app),
      MakeExportCommand(app),     MakeActCommand(app),      MakePoliciesCommand(app),
      MakeAlgorithmsCommand(app), MakeScenarioCommand(app), MakeReplayCommand(app)};
  for (const std::string& name : UnknownVariables(environ)) {
    fmt::print(stderr,
               "dadrl: the environment variable {} is set, and nothing reads it (there are: {}, {}, {})\n",
               name, kScenariosVariable, kPoliciesVariable, kIsaVariable);
  }
  if (RefuseUnknownCommand(argc, argv, commands)) return kWrongUsage;
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return ReportParseError(app, error);
  }
  for (const Command& command : commands) {
    if (!command.app->parsed()) continue;
    const Result<int> result = command.run();
    if (result) return *result;
    fmt::print(stderr, "dadrl {}: {}\n", command.app->get_name(), result.error().message);
    return ExitCode(result.error());
  }
  return kWrongUsage;
}

}  // namespace
}  // namespace dadrl

int main(int argc, char** argv) {
  dadrl::SetUpProcess();
  try {
    return dadrl::Main(argc, argv);
  } catch (const std::exception& exception) {
    fmt::print(stderr, "dadrl: {}\n", dadrl::ExceptionText(exception));
    return 1;
  }
}
