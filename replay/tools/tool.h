// `dadrl replay inspect | verify | export | import | restore | limit | snapshot`: what a user does with
// stored experience. `dadrl replay ...` becomes `dadrl-replay tool ...`.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "common/util/result.h"

namespace dadrl {

struct Tool {
  CLI::App* app = nullptr;
  // The exit code, or an error.
  std::function<Result<int>()> run;
};

Tool MakeInspectTool(CLI::App& replay);
Tool MakeVerifyTool(CLI::App& replay);
Tool MakeExportTool(CLI::App& replay);
Tool MakeImportTool(CLI::App& replay);
Tool MakeRestoreTool(CLI::App& replay);
Tool MakeLimitTool(CLI::App& replay);
Tool MakeSnapshotTool(CLI::App& replay);

// `argv[0]` is "tool". Returns the exit code.
int RunTool(int argc, char** argv);

}  // namespace dadrl
