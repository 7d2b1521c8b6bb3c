#include "actor/scenario_command.h"

#include <CLI/CLI.hpp>
#include <string_view>

#include "actor/check/check_command.h"
#include "actor/create/new_scenario.h"
#include "common/config/config_schema.h"
#include "common/util/log.h"

namespace dadrl {
namespace {

constexpr int kWrongUsage = 2;

// CLI11 takes an unknown word for a surplus argument; here it gets the nearest name.
bool RefuseUnknown(int argc, char** argv) {
  const std::vector<std::string> names = {"check", "new"};
  if (argc < 2 || argv[1][0] == '-' || std::ranges::find(names, argv[1]) != names.end()) return false;
  fmt::print(stderr, "dadrl scenario: unknown command '{}'; the nearest is '{}' (there are: {})\n", argv[1],
             NearestName(argv[1], names), fmt::join(names, ", "));
  return true;
}

}  // namespace

int RunScenarioCommand(int argc, char** argv) {
  InitLogging("scenario");
  CLI::App app("Explains scenarios, and makes them from road networks.", "dadrl scenario");
  app.require_subcommand(1);
  CheckOptions check;
  CLI::App* const check_command =
      app.add_subcommand("check", "Explain a scenario: what it has, what it costs, what is wrong with it");
  check.AddTo(*check_command);
  NewScenarioOptions made;
  CLI::App* const new_command =
      app.add_subcommand("new", "Make a scenario from a SUMO network, plain XML or an OpenStreetMap extract");
  made.AddTo(*new_command);
  if (RefuseUnknown(argc, argv)) return kWrongUsage;
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help
    fmt::print(stderr, "dadrl scenario: {} (dadrl scenario --help shows what there is)\n", error.what());
    return kWrongUsage;
  }
  const Result<int> code = check_command->parsed() ? RunCheck(check) : RunNewScenario(made);
  if (code) return *code;
  fmt::print(stderr, "dadrl scenario: {}\n", code.error().message);
  return ExitCode(code.error());
}

}  // namespace dadrl
