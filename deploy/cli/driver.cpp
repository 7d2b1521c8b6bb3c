#include "deploy/cli/driver.h"

#include <sys/mman.h>
#include <unistd.h>

#include <span>
#include <utility>

#include "common/config/config_yaml.h"
#include "common/model/policy_file.h"
#include "deploy/local/executables.h"

namespace dadrl {

Status CheckPolicy(const std::string& policy, const std::string& scenario, Config& config) {
  std::error_code error;
  const bool is_file = std::filesystem::exists(policy, error);
  const bool looks_like_file = policy.find_first_of("/.") != std::string::npos;
  if (!is_file && !looks_like_file) {
    if (!scenario.empty()) return {};
    return Fail(ErrorCode::kInvalidArgument, "--scenario is needed with --policy {}; there are: {}", policy,
                fmt::join(ScenarioNames(), ", "));
  }
  DADRL_ASSIGN_OR_RETURN(const PolicyFile file, LoadPolicy(policy));
  if (scenario.empty()) config.scenario = file.config.scenario;
  return {};
}

Result<SharedConfig> SharedConfig::Create(const Config& config) {
  FileDescriptor file(memfd_create("config", MFD_CLOEXEC));
  const std::string yaml = ToYaml(config, false);
  DADRL_RETURN_IF_ERROR(WriteAll(file, std::as_bytes(std::span(yaml)), "configuration"));
  return SharedConfig(std::move(file));
}

std::filesystem::path SharedConfig::path() const {
  return fmt::format("/proc/{}/fd/{}", getpid(), file_.get());
}

}  // namespace dadrl
