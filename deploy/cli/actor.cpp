#include <poll.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

#include "common/config/config_yaml.h"
#include "common/config/validate.h"
#include "common/dds/address.h"
#include "common/io/link_file.h"
#include "common/io/run_key.h"
#include "deploy/cli/command.h"
#include "deploy/local/cluster_processes.h"
#include "deploy/local/episode_log.h"
#include "deploy/local/fault_history.h"
#include "deploy/local/run_directory.h"
#include "deploy/local/run_finder.h"
#include "deploy/local/run_health.h"
#include "deploy/local/run_watch.h"
#include "deploy/local/signals.h"
#include "deploy/local/supervisor.h"

namespace dadrl {
namespace {

struct ActorOptions {
  std::string join;
  int actors = 1;
  int first_index = -1;  // -1: numbers that the run gives out
  std::string run_dir;
  std::string key_file;
  ConfigOptions config;
};

constexpr Duration kTick = std::chrono::milliseconds(200);

// A replay that was just killed is back within it.
constexpr Duration kPatience = std::chrono::seconds(15);

// The key that was named; on this machine otherwise that of the newest run here; "" when there is none.
Result<std::string> Key(const ActorOptions& options, const std::string& host) {
  if (!options.key_file.empty()) return ReadRunKey(options.key_file);
  DADRL_ASSIGN_OR_RETURN(const std::string address, dds::ResolveHost(host));
  if (!dds::IsLoopback(address)) return std::string();
  auto key = ReadRunKey(RunKeyFile(FollowLinks("runs/latest")));
  if (!key && key.error().code == ErrorCode::kNotFound) return std::string();
  return key;
}

// Without throwing where standard error is gone, as fmt::print would.
void Say(const std::string& text) { std::fputs((text + "\n").c_str(), stderr); }

// The actors of one join, from their start to the exit code.
class JoinedActors {
 public:
  JoinedActors(const RunPaths& paths, const Config& config, SignalWatcher& signals,
               std::unique_ptr<RunWatch> watch, EpisodeLog episodes)
      : signals_(signals),
        watch_(std::move(watch)),
        episodes_(std::move(episodes)),
        supervisor_(RestartLimits{}, HangLimits::Of(config.cluster), clock_, Say),
        health_(paths.processes(), clock_, faults_) {}

  // Supervises until the user stops it, the run has ended, or no actor is left.
  Result<int> Run(std::vector<ProcessSpec> specs) {
    BecomeSubreaper();
    for (ProcessSpec& spec : specs) DADRL_RETURN_IF_ERROR(supervisor_.Start(std::move(spec)));
    while (!supervisor_.AllEnded()) {
      std::vector<pollfd> fds = {{.fd = signals_.fd(), .events = POLLIN, .revents = 0}};
      supervisor_.AppendWaitFds(fds);
      const auto wait =
          std::chrono::duration_cast<std::chrono::milliseconds>(supervisor_.NextDeadline(kTick));
      poll(fds.data(), fds.size(), static_cast<int>(wait.count()));
      supervisor_.Step();
      ReapAdopted(supervisor_.RunningPids());
      KeepFiles();
      if (signals_.PauseRequested()) {
        signals_.PauseWith(supervisor_.RunningPids(), [&](Duration paused) { supervisor_.AddPause(paused); });
      }
      if (signals_.KillRequested()) supervisor_.KillAll();
      if (signals_.StopRequested()) {
        Stop("waiting for the actors to finish their step; once more Ctrl-C kills them");
      }
      LookAtRun();
    }
    KeepFiles();
    return lost_run_ || supervisor_.Lost() ? 1 : 0;
  }

 private:
  void LookAtRun() {
    const RunPresence::Verdict verdict = watch_->Look();
    if (const auto notice = watch_->TakeNotice()) Say(*notice);
    if (verdict == RunPresence::Verdict::kEnded) {
      Stop("the run has ended, and so do the actors that joined it");
    }
    if (verdict == RunPresence::Verdict::kGivenUp) {
      lost_run_ = true;
      Stop("the run does not come back: the actors that joined it end");
    }
  }
  // The episodes, and what a monitor is to know of the actors.
  void KeepFiles() {
    faults_.Report(FaultKind::kEpisodeLog, episodes_.Update());
    health_.Step(supervisor_, false);  // whether it trains is for the run to say
    std::vector<ProcessFault> lasting;
    for (Fault& fault : faults_.Current()) lasting.push_back({"launcher", std::move(fault)});
    for (const std::string& line : fault_history_.Update(lasting, clock_.Now())) Say(line);
  }
  void Stop(const char* why) {
    if (std::exchange(stopping_, true)) return;
    Say(why);
    supervisor_.StopRole(kActorRole);
  }

  const SystemClock clock_;
  SignalWatcher& signals_;
  const std::unique_ptr<RunWatch> watch_;
  EpisodeLog episodes_;
  Supervisor supervisor_;
  FaultBoard faults_{clock_, FaultBoard::Logging::kOff};  // what is said goes to the terminal
  FaultHistory fault_history_;
  RunHealth health_;
  bool stopping_ = false;
  bool lost_run_ = false;
};

// Those below belong to the run's own actors, which may be down at the moment and come back.
Status CheckFirstIndex(int first_index, const Config& run) {
  if (first_index < 0 || first_index >= run.actor.count) return {};
  return Fail(
      ErrorCode::kInvalidArgument,
      "--first-index: {} is one of the run's own actors, 0 to {}; choose {} or more, or leave it away",
      first_index, run.actor.count - 1, run.actor.count);
}

Result<int> RunJoin(const ActorOptions& options) {
  DADRL_ASSIGN_OR_RETURN(const std::unique_ptr<SignalWatcher> signals, SignalWatcher::Create());
  DADRL_ASSIGN_OR_RETURN(RunPlace place, ParseRunPlace(options.join));
  DADRL_ASSIGN_OR_RETURN(const Config own, options.config.Apply(Config{}));  // before anything waits
  place.mtu = own.cluster.mtu;
  DADRL_ASSIGN_OR_RETURN(place.key, Key(options, place.host));
  DADRL_ASSIGN_OR_RETURN(const Config run, FindRun(place, kPatience, [&] {
                           if (signals->PauseRequested()) signals->PauseWith({});
                           return signals->StopRequested();
                         }));
  DADRL_ASSIGN_OR_RETURN(const Config config, options.config.Apply(run));
  DADRL_RETURN_IF_ERROR(Validate(config));
  DADRL_RETURN_IF_ERROR(CheckFirstIndex(options.first_index, run));
  const auto root = options.run_dir.empty() ? NewRunPath("runs", "join-" + place.host)
                                            : std::filesystem::path(options.run_dir);
  DADRL_ASSIGN_OR_RETURN(const RunDirectory directory, RunDirectory::CreateNew(root));
  DADRL_RETURN_IF_ERROR(directory.SaveConfig(config));
  if (!place.key.empty()) DADRL_RETURN_IF_ERROR(SaveRunKey(root, place.key));
  const bool chosen = options.first_index >= 0;
  DADRL_ASSIGN_OR_RETURN(std::vector<ProcessSpec> specs,
                         ActorProcesses(directory.paths(), chosen ? options.first_index : 0, options.actors,
                                        chosen ? ActorNumbers::kOwn : ActorNumbers::kGiven));
  const SystemClock clock;
  DADRL_ASSIGN_OR_RETURN(auto watch, RunWatch::Create(config, place.key, clock));
  fmt::print(stderr, "{} actors join {}; logs in {}\n", options.actors, options.join,
             directory.paths().logs().string());
  DADRL_ASSIGN_OR_RETURN(EpisodeLog episodes,
                         EpisodeLog::Open(directory.paths().episodes(), directory.paths().logs()));
  return JoinedActors(directory.paths(), config, *signals, std::move(watch), std::move(episodes))
      .Run(std::move(specs));
}

}  // namespace

Command MakeActorCommand(CLI::App& dadrl) {
  auto options = std::make_shared<ActorOptions>();
  CLI::App* app =
      dadrl.add_subcommand("actor", "Add actors on this machine to a cluster that runs elsewhere");
  app->add_option(
         "--join", options->join,
         "Where the cluster runs; on another machine it must have been started with cluster.host set "
         "to an address this machine reaches")
      ->required()
      ->type_name("HOST[:PORT]");
  app->add_option("--actors", options->actors, "How many (default 1)")->check(CLI::Range(1, 4096));
  app->add_option("--first-index", options->first_index,
                  "Numbers from here on for the actors, or none at all: those that others hold are refused "
                  "(default: free numbers, which the run gives out)")
      ->check(CLI::Range(0, 900'000));
  app->add_option("--key", options->key_file,
                  "The run's key, needed for a run on 127.0.0.1 and one with cluster.require_key (default: "
                  "runs/latest/key)")
      ->type_name("RUN/key");
  app->add_option("--run-dir", options->run_dir, "For the logs (default: runs/join-HOST-TIME)")
      ->type_name("DIR");
  options->config.AddTo(*app);
  return {app, [options] { return RunJoin(*options); }};
}

}  // namespace dadrl
