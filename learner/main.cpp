// dadrl-learner --config FILE --run-dir DIR [--resume]; `dadrl-learner algorithms [--json]` lists them.
#include <CLI/CLI.hpp>
#include <exception>
#include <filesystem>
#include <string_view>

#include "common/config/config_yaml.h"
#include "common/config/validate.h"
#include "common/liveness/stack_dump.h"
#include "common/liveness/working_thread.h"
#include "common/util/fault.h"
#include "common/util/log.h"
#include "common/util/process_setup.h"
#include "common/util/shutdown.h"
#include "learner/learner_process.h"
#include "learner/list_algorithms.h"

namespace {

dadrl::Status Learn(const std::filesystem::path& config_file, const std::filesystem::path& run_directory,
                    bool resume) {
  dadrl::Config config;
  DADRL_RETURN_IF_ERROR(dadrl::LoadYaml(config_file, config));
  DADRL_RETURN_IF_ERROR(dadrl::Validate(config));
  return dadrl::RunLearner(config, run_directory, resume);
}

}  // namespace

int main(int argc, char** argv) {
  dadrl::SetUpProcess();
  if (argc > 1 && std::string_view(argv[1]) == "algorithms") {
    fmt::print("{}", dadrl::AlgorithmList(argc > 2 && std::string_view(argv[2]) == "--json"));
    return 0;
  }
  CLI::App app("Trains the policy from the replay's experience and broadcasts it to the actors.",
               "dadrl-learner");
  std::filesystem::path config_file;
  std::filesystem::path run_directory;
  bool resume = false;
  app.add_option("--config", config_file, "Configuration of the run, YAML")->required();
  app.add_option("--run-dir", run_directory, "Folder of the run: checkpoints, logs, tensorboard")->required();
  app.add_flag("--resume", resume, "Go on from the newest checkpoint of the run");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  dadrl::InitLogging("learner");
  dadrl::InstallShutdownHandler();
  dadrl::InstallStackDump();
  dadrl::ProcessFaults().Follow(dadrl::ReportFault);
  try {
    const dadrl::Status status = Learn(config_file, run_directory, resume);
    if (status) return 0;
    spdlog::error("{}", status.error().message);
    return dadrl::ExitCode(status.error());
  } catch (const std::exception& exception) {
    spdlog::error("{}", dadrl::ExceptionText(exception));
    return 1;
  }
}
