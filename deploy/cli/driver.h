// What the commands that let dadrl-actor drive a policy have in common.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "common/config/config.h"
#include "common/util/result.h"
#include "deploy/cli/command.h"
#include "deploy/local/shared_file.h"
#include "deploy/local/signals.h"

namespace dadrl {

// Ready to be handed to dadrl-actor.
struct Driver {
  std::filesystem::path program;  // dadrl-actor
  std::string policy;             // a file, or the name of a scripted driver
  Config config;                  // effective; its scenario is the one to drive
  SharedFile shared;              // the same as a file
};

// Who drives, and where.
struct DriverOptions {
  std::string policy;    // a file, pretrained:NAME or a scripted driver
  std::string scenario;  // empty: the one a learned policy was trained on
  ConfigOptions config;

  // --policy and --scenario; the configuration's options are left to `config.AddTo`.
  void AddTo(CLI::App& app, const std::string& scenario_help);
  // Reads a policy that is a file, so that a damaged one is one clear message; any other word is left to
  // dadrl-actor, which knows the scripted drivers. kInvalidArgument also when no scenario can be told.
  Result<Driver> Resolve() const;
};

// Refuses what `dadrl scenario check` refuses, in the same words, before anything starts; its warnings go to
// standard error in the name of `command`. Errors as CheckDrivable.
Status RequireDrivable(const Config& config, std::string_view command, SignalWatcher* signals);

}  // namespace dadrl
