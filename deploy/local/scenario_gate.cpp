#include "deploy/local/scenario_gate.h"

#include <poll.h>

#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>

#include "common/config/config_schema.h"
#include "common/config/config_yaml.h"
#include "deploy/local/captured_process.h"
#include "deploy/local/executables.h"
#include "deploy/local/shared_file.h"

namespace dadrl {
namespace {

constexpr int kTickMs = 100;

Result<ExitStatus> WaitFor(CapturedProcess& process, const std::string& scenario, SignalWatcher* signals) {
  for (;;) {
    if (const auto ended = process.child().TryWait()) return *ended;
    std::array<pollfd, 2> fds = {
        {{.fd = process.child().pidfd(), .events = POLLIN, .revents = 0},
         {.fd = signals == nullptr ? -1 : signals->fd(), .events = POLLIN, .revents = 0}}};
    poll(fds.data(), fds.size(), kTickMs);
    if (signals != nullptr && signals->PauseRequested()) signals->PauseWith({process.child().pid()});
    if (signals != nullptr && signals->StopRequested()) {
      return Fail(ErrorCode::kUnavailable, "stopped while scenario '{}' was checked", scenario);
    }
    if (const auto hangs = process.Hangs()) {
      return Fail(ErrorCode::kInternal, "the check of scenario '{}' hangs: {}", scenario, *hangs);
    }
  }
}

Result<std::vector<std::string>> ReadVerdict(const CapturedProcess& process, const ExitStatus& status,
                                             const std::string& scenario) {
  const std::vector<std::string> lines = process.OutputLines();
  const auto json = lines.empty() ? nlohmann::json() : nlohmann::json::parse(lines.back(), nullptr, false);
  if (json.is_object() && json.contains("error") && json["error"].is_string()) {
    return Fail(status.value == 2 ? ErrorCode::kInvalidArgument : ErrorCode::kInternal, "{}",
                json["error"].get<std::string>());
  }
  if (!status.success() || !json.is_object()) {
    return Fail(ErrorCode::kInternal, "the check of scenario '{}' ended with {}: {}", scenario,
                status.Describe(), process.LastMessage());
  }
  std::vector<std::string> warnings;
  for (const auto& warning : json.value("warnings", nlohmann::json::array())) {
    if (warning.is_string()) warnings.push_back(warning.get<std::string>());
  }
  return warnings;
}

}  // namespace

Result<std::vector<std::string>> CheckDrivable(const Config& config, SignalWatcher* signals) {
  DADRL_ASSIGN_OR_RETURN(const std::filesystem::path program, FindExecutable("dadrl-actor"));
  const std::string yaml = ToYaml(config, false);
  DADRL_ASSIGN_OR_RETURN(const SharedFile shared,
                         SharedFile::Create("config.yaml", std::as_bytes(std::span(yaml))));
  std::vector<std::string> warnings;
  const std::vector<std::string> names =
      config.scenario == kAllScenarios ? ScenarioNames() : std::vector{config.scenario};
  for (const std::string& name : names) {
    DADRL_ASSIGN_OR_RETURN(
        CapturedProcess process,
        CapturedProcess::Spawn({program.string(), "scenario", "check", "--json", "--config",
                                shared.path().string(), (ScenarioFolder() / name).string()},
                               0, HangLimits::Of(config.cluster)));
    DADRL_ASSIGN_OR_RETURN(const ExitStatus status, WaitFor(process, name, signals));
    DADRL_ASSIGN_OR_RETURN(const std::vector<std::string> of_this, ReadVerdict(process, status, name));
    for (const std::string& warning : of_this) warnings.push_back(fmt::format("{}: {}", name, warning));
  }
  return warnings;
}

}  // namespace dadrl
