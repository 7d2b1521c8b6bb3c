// dadrl-replay: one shard of the replay service; `dadrl-replay tool ...`: what users do with
// stored experience (tools/tool.h).
#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include "common/config/config_yaml.h"
#include "common/config/validate.h"
#include "common/io/incarnation.h"
#include "common/liveness/stack_dump.h"
#include "common/liveness/working_thread.h"
#include "common/util/fault.h"
#include "common/util/log.h"
#include "common/util/process_setup.h"
#include "common/util/shutdown.h"
#include "replay/service/replay_service.h"
#include "replay/tools/tool.h"

namespace {

constexpr int kWrongUsage = 2;

dadrl::Result<uint64_t> Incarnation(const std::string& text, const dadrl::ReplayService::Options& options) {
  if (text == "auto") {
    return dadrl::NextIncarnation(options.run_directory, fmt::format("replay-{}", options.shard),
                                  dadrl::WallTimeNs());
  }
  uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    return dadrl::Fail(dadrl::ErrorCode::kInvalidArgument, "--incarnation: '{}' is neither auto nor a number",
                       text);
  }
  return value;
}

dadrl::Status Run(const std::filesystem::path& config_file, dadrl::ReplayService::Options options,
                  const std::string& incarnation) {
  DADRL_ASSIGN_OR_RETURN(options.incarnation, Incarnation(incarnation, options));
  DADRL_RETURN_IF_ERROR(dadrl::LoadYaml(config_file, options.config));
  DADRL_RETURN_IF_ERROR(dadrl::Validate(options.config));
  if (std::cmp_greater_equal(options.shard, options.config.replay.shards)) {
    return dadrl::Fail(dadrl::ErrorCode::kInvalidArgument, "--shard: {} does not exist, replay.shards is {}",
                       options.shard, options.config.replay.shards);
  }
  dadrl::SystemClock clock;
  DADRL_ASSIGN_OR_RETURN(const auto service, dadrl::ReplayService::Create(options, clock));
  return service->Run(dadrl::shutdown_requested);
}

}  // namespace

int main(int argc, char** argv) {
  dadrl::SetUpProcess();
  if (argc > 1 && std::string_view(argv[1]) == "tool") return dadrl::RunTool(argc - 1, argv + 1);
  CLI::App app("Stores the actors' experience and serves batches of it to the learner.", "dadrl-replay");
  std::string config_file;
  std::string incarnation = "auto";
  dadrl::ReplayService::Options options;
  app.add_option("--config", config_file, "Configuration of the run, YAML")->required();
  app.add_option("--run-dir", options.run_directory, "Folder of the run")->required();
  app.add_option("--shard", options.shard, "Which shard this is, from 0")->required();
  app.add_option("--incarnation", incarnation, "A number that grows with each start, or auto")
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kWrongUsage;
  }
  dadrl::InitLogging(fmt::format("replay-{}", options.shard));
  dadrl::InstallShutdownHandler();
  dadrl::InstallStackDump();
  dadrl::ProcessFaults().Follow(dadrl::ReportFault);
  if (const dadrl::Status done = Run(config_file, std::move(options), incarnation); !done) {
    spdlog::error("{}", done.error().message);
    return dadrl::ExitCode(done.error());
  }
  return 0;
}
