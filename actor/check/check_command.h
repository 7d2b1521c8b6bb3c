// `dadrl scenario check DIR...`: explains scenarios, and refuses those that cannot be driven.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "common/util/result.h"

namespace dadrl {

struct CheckOptions {
  std::vector<std::string> scenarios;  // folders, or names of scenarios
  std::string config;                  // file; empty: defaults
  std::vector<std::string> sets;       // "key=value"
  std::string picture;                 // file to draw into; of one scenario
  bool json = false;

  void AddTo(CLI::App& app);
};

// Prints a report each on standard output, a refusal on standard error (with `json` both as a line of JSON on
// standard output). The exit code: 0 when all can be driven, else that of the first that cannot.
Result<int> RunCheck(const CheckOptions& options);

// Checks the scenario `name` of `directory` and prints its report. Errors as CheckScenario.
Status PrintCheck(const std::string& name, const std::filesystem::path& directory,
                  const CheckOptions& options);

}  // namespace dadrl
