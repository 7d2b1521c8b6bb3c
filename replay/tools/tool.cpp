#include "replay/tools/tool.h"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "common/config/config_schema.h"
#include "common/util/log.h"

namespace dadrl {
namespace {

constexpr int kWrongUsage = 2;

// CLI11 takes an unknown word for a surplus argument; here it gets the nearest name.
bool RefuseUnknownTool(int argc, char** argv, const std::vector<Tool>& tools) {
  if (argc < 2 || argv[1][0] == '-') return false;
  std::vector<std::string> names;
  for (const Tool& tool : tools) names.push_back(tool.app->get_name());
  if (std::find(names.begin(), names.end(), argv[1]) != names.end()) return false;
  fmt::print(stderr, "dadrl replay: unknown command '{}'; the nearest is '{}' (there are: {})\n", argv[1],
             NearestName(argv[1], names), fmt::join(names, ", "));
  return true;
}

}  // namespace

int RunTool(int argc, char** argv) {
  InitLogging("dadrl-replay");
  CLI::App app("Looks at stored experience, checks it, moves it; changes a running replay.", "dadrl replay");
  app.require_subcommand(1);
  const std::vector<Tool> tools = {MakeInspectTool(app), MakeVerifyTool(app),  MakeExportTool(app),
                                   MakeImportTool(app),  MakeRestoreTool(app), MakeLimitTool(app),
                                   MakeSnapshotTool(app)};
  if (RefuseUnknownTool(argc, argv, tools)) return kWrongUsage;
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help
    fmt::print(stderr, "dadrl replay: {} (dadrl replay --help shows what there is)\n", error.what());
    return kWrongUsage;
  }
  for (const Tool& tool : tools) {
    if (!tool.app->parsed()) continue;
    const Result<int> result = tool.run();
    if (result) return *result;
    fmt::print(stderr, "dadrl replay {}: {}\n", tool.app->get_name(), result.error().message);
    return ExitCode(result.error());
  }
  return kWrongUsage;
}

}  // namespace dadrl
