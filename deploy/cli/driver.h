// What the commands that let dadrl-actor drive a policy have in common.
#pragma once

#include <filesystem>
#include <string>

#include "common/config/config.h"
#include "common/io/file_descriptor.h"
#include "common/util/result.h"

namespace dadrl {

// Reads a policy (as ResolvePolicy returns it) that is a file, so that a damaged one is one clear message;
// any other word is left to dadrl-actor, which knows the scripted drivers. Without a `scenario`, puts the one
// a learned policy was trained on into `config`; kInvalidArgument when there is none to take.
Status CheckPolicy(const std::string& policy, const std::string& scenario, Config& config);

// An effective configuration as a file that child processes can open while this object lives.
class SharedConfig {
 public:
  static Result<SharedConfig> Create(const Config& config);
  std::filesystem::path path() const;

 private:
  explicit SharedConfig(FileDescriptor file) : file_(std::move(file)) {}
  FileDescriptor file_;
};

}  // namespace dadrl
