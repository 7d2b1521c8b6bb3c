#include "actor/check/check_command.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "actor/check/scenario_check.h"
#include "actor/check/scenario_picture.h"
#include "common/config/config_yaml.h"
#include "common/config/validate.h"
#include "common/io/atomic_file.h"
#include "common/liveness/working_thread.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

Result<Config> ConfigOf(const CheckOptions& options) {
  Config config;
  if (!options.config.empty()) DADRL_RETURN_IF_ERROR(LoadYaml(options.config, config));
  for (const std::string& assignment : options.sets) {
    DADRL_RETURN_IF_ERROR(ApplyOverride(assignment, config));
  }
  DADRL_RETURN_IF_ERROR(Validate(config));
  return config;
}

// A folder with a scenario in it, or the name of one.
ScenarioPlace Find(const std::string& scenario) {
  std::error_code error;
  const bool is_path = scenario.find('/') != std::string::npos || scenario == "." || scenario == "..";
  if (is_path || fs::exists(fs::path(scenario) / "scenario.yaml", error)) return PlaceOf(scenario);
  return {scenario, ScenarioDirectory()};
}

void PrintRefusal(const std::string& scenario, const Error& error, bool json) {
  if (!json) {
    fmt::print(stderr, "dadrl scenario: {}\n", error.message);
    return;
  }
  const nlohmann::ordered_json object = {
      {"scenario", scenario}, {"drivable", false}, {"error", error.message}};
  fmt::print("{}\n", object.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

}  // namespace

void CheckOptions::AddTo(CLI::App& app) {
  app.add_option("scenario", scenarios, "Folders with a scenario.yaml, or names of scenarios")
      ->required()
      ->type_name("DIR");
  app.add_flag("--json", json, "One JSON object each on standard output");
  app.add_option("--picture", picture, "Draws roads, route, start, goal and traffic (one DIR only)")
      ->type_name("FILE.svg");
  app.add_option("--config", config, "YAML file: what it would be trained with")->type_name("FILE");
  app.add_option("--set", sets, "One key, e.g. --set task.max_speed_mps=30; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
}

Status PrintCheck(const std::string& name, const fs::path& directory, const CheckOptions& options) {
  DADRL_ASSIGN_OR_RETURN(Config config, ConfigOf(options));
  config.scenario = name;
  const WorkingThread working("check");
  DADRL_ASSIGN_OR_RETURN(const CheckedScenario checked, CheckScenario(config, directory));
  if (!options.picture.empty()) {
    DADRL_RETURN_IF_ERROR(checked.environment->Reset(checked.seed));
    DADRL_RETURN_IF_ERROR(WriteFileAtomically(
        options.picture, std::string_view(ScenarioPicture(*checked.environment, checked.scenario))));
  }
  fmt::print("{}{}", options.json ? ReportJson(checked.report) : ReportText(checked.report),
             options.json ? "\n" : "");
  return {};
}

Result<int> RunCheck(const CheckOptions& options) {
  if (!options.picture.empty() && options.scenarios.size() > 1) {
    return Fail(ErrorCode::kInvalidArgument, "--picture draws one scenario; {} are given",
                options.scenarios.size());
  }
  int code = 0;
  for (const std::string& scenario : options.scenarios) {
    const ScenarioPlace place = Find(scenario);
    const Status checked = PrintCheck(place.name, place.directory, options);
    if (checked) continue;
    PrintRefusal(scenario, checked.error(), options.json);
    if (code == 0) code = ExitCode(checked.error());
  }
  return code;
}

}  // namespace dadrl
