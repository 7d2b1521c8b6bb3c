// dadrl-lockstep --config FILE --run-dir DIR: what `dadrl train --deterministic` runs.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/config/config_yaml.h"
#include "common/config/validate.h"
#include "common/util/log.h"
#include "common/util/process_setup.h"
#include "common/util/shutdown.h"
#include "deploy/lockstep/lockstep.h"

namespace {

dadrl::Result<dadrl::LockstepResult> Train(const std::filesystem::path& config_file,
                                           const std::filesystem::path& run_directory) {
  dadrl::Config config;
  DADRL_RETURN_IF_ERROR(dadrl::LoadYaml(config_file, config));
  DADRL_RETURN_IF_ERROR(dadrl::Validate(config));
  return dadrl::TrainInLockstep(config, run_directory, dadrl::shutdown_requested);
}

}  // namespace

int main(int argc, char** argv) {
  dadrl::SetUpProcess();
  CLI::App app("Trains in one process, actor, replay and learner in turns: same seed, same weights.",
               "dadrl-lockstep");
  std::filesystem::path config_file;
  std::filesystem::path run_directory;
  app.add_option("--config", config_file, "Configuration of the run, YAML")->required();
  app.add_option("--run-dir", run_directory, "Folder of the run; gets checkpoints/")->required();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  dadrl::InitLogging("lockstep");
  dadrl::InstallShutdownHandler();
  try {
    const auto result = Train(config_file, run_directory);
    if (!result) {
      spdlog::error("{}", result.error().message);
      return dadrl::ExitCode(result.error());
    }
    const nlohmann::json line = {{"updates", result->updates},
                                 {"episodes", result->episodes},
                                 {"decisions", result->decisions},
                                 {"policy_hash", fmt::format("{:016x}", result->policy_hash)}};
    std::puts(line.dump().c_str());
    return 0;
  } catch (const std::exception& exception) {
    spdlog::error("{}", dadrl::ExceptionText(exception));
    return 1;
  }
}
