// What the commands that let dadrl-actor drive a policy have in common.
#pragma once

#include <filesystem>
#include <string>

#include "common/config/config.h"
#include "common/io/file_descriptor.h"
#include "common/util/result.h"
#include "deploy/cli/command.h"

namespace dadrl {

// An effective configuration as a file that child processes can open while this object lives.
class SharedConfig {
 public:
  static Result<SharedConfig> Create(const Config& config);
  std::filesystem::path path() const;

 private:
  explicit SharedConfig(FileDescriptor file) : file_(std::move(file)) {}
  FileDescriptor file_;
};

// Ready to be handed to dadrl-actor.
struct Driver {
  std::filesystem::path program;  // dadrl-actor
  std::string policy;             // a file, or the name of a scripted driver
  Config config;                  // effective; its scenario is the one to drive
  SharedConfig shared;            // the same as a file
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

}  // namespace dadrl
