#include <poll.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/config/config_schema.h"
#include "deploy/cli/command.h"
#include "deploy/cli/driver.h"
#include "deploy/local/captured_process.h"
#include "deploy/local/executables.h"
#include "deploy/local/signals.h"
#include "proto/evaluation/episode_line.h"
#include "proto/evaluation/rendered_episode.h"
#include "proto/evaluation/seed_range.h"

namespace dadrl {
namespace {

struct RenderOptions {
  DriverOptions driver;
  std::string out;
  std::optional<uint64_t> seed;
  std::string seeds;
  std::string outcome;
  std::vector<std::string> passed_on;  // options that only dadrl-actor looks at
  bool json = false;

  bool gallery() const { return !seeds.empty(); }
};

constexpr int kTickMs = 200;

// Drives and draws in a process of its own, because SUMO can abort.
class RenderJob {
 public:
  RenderJob(std::vector<std::string> command, SeedRange seeds, bool gallery)
      : command_(std::move(command)), left_(seeds), gallery_(gallery), planned_(seeds.count) {}

  // Until all seeds are done. kUnavailable: the user stopped it.
  Status Run(SignalWatcher& signals);
  const std::vector<RenderedEpisode>& episodes() const { return episodes_; }

 private:
  Status RunProcess(SignalWatcher& signals);
  // Until the process has ended; `hung` says why it had to be killed, if so.
  Status Wait(CapturedProcess& process, SignalWatcher& signals, ExitStatus& status, std::string& hung);

  std::vector<std::string> command_;
  SeedRange left_;
  bool gallery_;
  int planned_;
  std::vector<RenderedEpisode> episodes_;
};

Status RenderJob::Wait(CapturedProcess& process, SignalWatcher& signals, ExitStatus& status,
                       std::string& hung) {
  const bool terminal = gallery_ && isatty(STDERR_FILENO) == 1;
  for (;;) {
    if (const auto ended = process.child().TryWait()) {
      status = *ended;
      if (terminal) fmt::print(stderr, "\r\x1b[K");
      return {};
    }
    std::array<pollfd, 2> fds = {{{.fd = signals.fd(), .events = POLLIN, .revents = 0},
                                  {.fd = process.child().pidfd(), .events = POLLIN, .revents = 0}}};
    poll(fds.data(), fds.size(), kTickMs);
    if (process.Overflows()) {
      return Fail(ErrorCode::kInternal, "{} printed more than {} bytes: it is not the program that draws",
                  command_.front(), kMaxCapturedBytes);
    }
    const size_t done = episodes_.size() + static_cast<size_t>(process.OutputLineCount());
    if (signals.PauseRequested()) signals.PauseWith({process.child().pid()});
    if (const auto why = process.Hangs(); why && hung.empty()) {
      hung = *why;
      process.child().Signal(SIGKILL);
    }
    if (signals.StopRequested()) {
      return Fail(ErrorCode::kUnavailable, "stopped after {} of {} episodes", done, planned_);
    }
    if (terminal) fmt::print(stderr, "\r{} of {} episodes", done, planned_);
  }
}

// Draws the seeds that are left until the process ends; an episode in which it died counts as lost.
Status RenderJob::RunProcess(SignalWatcher& signals) {
  std::vector<std::string> command = command_;
  const std::vector<std::string> seeds =
      gallery_ ? std::vector<std::string>{"--seeds", ToText(left_)}
               : std::vector<std::string>{"--seed", fmt::format("{}", left_.first)};
  command.insert(command.end(), seeds.begin(), seeds.end());
  DADRL_ASSIGN_OR_RETURN(CapturedProcess process, CapturedProcess::Spawn(std::move(command)));
  ExitStatus status;
  std::string hung;
  DADRL_RETURN_IF_ERROR(Wait(process, signals, status, hung));
  for (const std::string& line : process.OutputLines()) {
    DADRL_ASSIGN_OR_RETURN(RenderedEpisode episode, ParseRenderedLine(line));
    episodes_.push_back(std::move(episode));
    ++left_.first;
    --left_.count;
  }
  if (status.success()) return {};
  const std::string message = process.LastMessage();
  if (!status.signaled) {
    const ErrorCode code = status.value == 2 ? ErrorCode::kInvalidArgument : ErrorCode::kInternal;
    return tl::unexpected<Error>(Error{code, message.empty() ? status.Describe() : message});
  }
  RenderedEpisode lost{.seed = left_.first};
  lost.error = hung.empty() ? fmt::format("its process ended with {}: {}", status.Describe(), message)
                            : fmt::format("its process hung and was killed: {}", hung);
  episodes_.push_back(std::move(lost));
  ++left_.first;
  --left_.count;
  return {};
}

Status RenderJob::Run(SignalWatcher& signals) {
  while (left_.count > 0) DADRL_RETURN_IF_ERROR(RunProcess(signals));
  return {};
}

nlohmann::ordered_json EpisodeJson(const RenderedEpisode& episode) {
  nlohmann::ordered_json json = {{"seed", episode.seed}};
  if (!episode.error.empty()) {
    json["error"] = episode.error;
    return json;
  }
  json["outcome"] = OutcomeName(episode.outcome);
  json["steps"] = episode.steps;
  json["return"] = episode.episode_return;
  json["files"] = episode.files;
  return json;
}

void PrintJson(const RenderOptions& options, const std::string& scenario,
               const std::vector<RenderedEpisode>& episodes) {
  nlohmann::ordered_json json = {{"scenario", scenario}, {"policy", options.driver.policy}};
  if (options.gallery()) {
    json["driven"] = episodes.size();
    json["episodes"] = nlohmann::ordered_json::array();
    for (const RenderedEpisode& episode : episodes) {
      if (!episode.files.empty() || !episode.error.empty()) json["episodes"].push_back(EpisodeJson(episode));
    }
  } else {
    json.update(EpisodeJson(episodes.front()));
  }
  fmt::print("{}\n", json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

void PrintText(const RenderOptions& options, const std::vector<RenderedEpisode>& episodes) {
  int drawn = 0;
  for (const RenderedEpisode& episode : episodes) {
    if (!episode.error.empty()) fmt::print("seed {}: lost, {}\n", episode.seed, episode.error);
    if (episode.files.empty()) continue;
    ++drawn;
    const std::string files = episode.files.size() == 1
                                  ? episode.files.front()
                                  : fmt::format("{} frames in {}", episode.files.size(), options.out);
    fmt::print("seed {}: {}, return {:.2f}: {}\n", episode.seed, episode.sentence, episode.episode_return,
               files);
  }
  if (options.gallery()) fmt::print("{} of {} episodes drawn in {}\n", drawn, episodes.size(), options.out);
}

Result<int> RunRender(const RenderOptions& options) {
  DADRL_ASSIGN_OR_RETURN(const std::unique_ptr<SignalWatcher> signals, SignalWatcher::Create());
  DADRL_ASSIGN_OR_RETURN(const Driver driver, options.driver.Resolve());
  if (driver.config.scenario == kAllScenarios) {
    return Fail(ErrorCode::kInvalidArgument,
                "one scenario is drawn: choose it with --scenario; there are: {}",
                fmt::join(ScenarioNames(), ", "));
  }
  DADRL_RETURN_IF_ERROR(RequireDrivable(driver.config, "render", signals.get()));
  SeedRange seeds{options.seed.value_or(kFirstEvaluationSeed), 1};
  if (options.gallery()) {
    DADRL_ASSIGN_OR_RETURN(seeds, ParseSeedRange(options.seeds));
  }
  std::vector<std::string> command = {driver.program,       "render", "--policy", driver.policy, "--config",
                                      driver.shared.path(), "--out",  options.out};
  if (!options.outcome.empty()) command.insert(command.end(), {"--outcome", options.outcome});
  command.insert(command.end(), options.passed_on.begin(), options.passed_on.end());
  RenderJob job(std::move(command), seeds, options.gallery());
  DADRL_RETURN_IF_ERROR(job.Run(*signals));
  const std::vector<RenderedEpisode>& episodes = job.episodes();
  if (!options.gallery() && !episodes.front().error.empty()) {
    return Fail(ErrorCode::kInternal, "seed {}: {}", episodes.front().seed, episodes.front().error);
  }
  if (options.json) {
    PrintJson(options, driver.config.scenario, episodes);
  } else {
    PrintText(options, episodes);
  }
  return 0;
}

}  // namespace

Command MakeRenderCommand(CLI::App& dadrl) {
  auto options = std::make_shared<RenderOptions>();
  CLI::App* app = dadrl.add_subcommand("render", "Draw what happens in an episode");
  options->driver.AddTo(*app, "Default: the one the policy was trained on");
  app->add_option("--out", options->out,
                  "FILE.svg: an animation; FILE.png: a strip of moments; FOLDER/: a frame for each moment")
      ->required();
  auto* seed = app->add_option("--seed", options->seed, "Traffic seed (default 1000000)")->type_name("K");
  app->add_option("--seeds", options->seeds, "Draws a strip of each of these episodes into FOLDER/")
      ->type_name("FIRST:COUNT")
      ->excludes(seed);
  app->add_option("--outcome", options->outcome, "With --seeds: only episodes that end so")
      ->check(CLI::IsMember({"success", "collision", "off_road", "stagnation"}));
  const auto pass_on = [options, app](const char* name, const char* help, const char* type,
                                      const CLI::Validator& check) {
    app->add_option_function<std::string>(
           name,
           [options, name](const std::string& value) {
             options->passed_on.insert(options->passed_on.end(), {name, value});
           },
           help)
        ->type_name(type)
        ->check(check);
  };
  pass_on("--every", "Simulation steps between moments (default: 1 in an animation, 5 in a folder)", "STEPS",
          CLI::Range(1, 1000));
  pass_on("--moments", "In a strip (default 6)", "N", CLI::Range(2, 24));
  pass_on("--from", "Begin of the part to draw", "SECONDS", CLI::NonNegativeNumber);
  pass_on("--to", "End of the part to draw (default: the episode's)", "SECONDS", CLI::NonNegativeNumber);
  app->add_flag("--json", options->json, "One JSON object on standard output");
  options->driver.config.AddTo(*app);
  return {app, [options] { return RunRender(*options); }};
}

}  // namespace dadrl
