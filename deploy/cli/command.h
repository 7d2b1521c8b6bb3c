// The commands of `dadrl`, one a file. Each adds its options to the application and runs when it was chosen.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/util/result.h"

namespace dadrl {

struct Command {
  CLI::App* app = nullptr;
  // The exit code, or an error that main prints (exit code by ExitCode).
  std::function<Result<int>()> run;
};

Command MakeTrainCommand(CLI::App& dadrl);
Command MakeCollectCommand(CLI::App& dadrl);
Command MakeEvaluateCommand(CLI::App& dadrl);
Command MakeSelectCommand(CLI::App& dadrl);
Command MakeRenderCommand(CLI::App& dadrl);
Command MakeMonitorCommand(CLI::App& dadrl);
Command MakeActorCommand(CLI::App& dadrl);
Command MakeDoctorCommand(CLI::App& dadrl);
Command MakeConfigCommand(CLI::App& dadrl);
Command MakeReplayCommand(CLI::App& dadrl);
Command MakeScenarioCommand(CLI::App& dadrl);
Command MakeExportCommand(CLI::App& dadrl);
Command MakeActCommand(CLI::App& dadrl);
Command MakePoliciesCommand(CLI::App& dadrl);
Command MakeAlgorithmsCommand(CLI::App& dadrl);

// Options shared by commands that take a configuration.
struct ConfigOptions {
  std::string file;
  std::vector<std::string> sets;  // "key=value"

  void AddTo(CLI::App& app);
  // Overlays file, then sets, on `base`; model.policy is one that there is.
  Result<Config> Apply(Config base) const;
  // The same on the defaults and, over these, the preset of the algorithm that file or sets name.
  Result<Config> ApplyToPreset() const;
};

}  // namespace dadrl
