#include <poll.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <utility>

#include "common/config/config_yaml.h"
#include "common/config/validate.h"
#include "common/dds/address.h"
#include "common/io/run_key.h"
#include "common/util/random.h"
#include "deploy/cli/command.h"
#include "deploy/local/cluster_processes.h"
#include "deploy/local/episode_log.h"
#include "deploy/local/run_directory.h"
#include "deploy/local/run_finder.h"
#include "deploy/local/signals.h"
#include "deploy/local/supervisor.h"

namespace dadrl {
namespace {

struct ActorOptions {
  std::string join;
  int actors = 1;
  int first_index = -1;  // -1: drawn
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
  return dds::IsLoopback(address) ? LoadRunKey("runs/latest") : std::string();
}

// Numbers that no other joining machine will have, and far from those of the cluster's own actors.
int DrawFirstIndex(int actors) {
  constexpr uint64_t kLast = 1'000'000;
  Random random(DeriveSeed(static_cast<uint64_t>(WallTimeNs()), static_cast<uint64_t>(getpid())));
  return 10'000 + static_cast<int>(random.Below(kLast - 10'000 - static_cast<uint64_t>(actors)));
}

// Without throwing where standard error is gone, as fmt::print would.
void Say(const std::string& text) { std::fputs((text + "\n").c_str(), stderr); }

// Supervises until the user stops it or no actor is left.
Result<int> RunActors(std::vector<ProcessSpec> specs, EpisodeLog episodes, SignalWatcher& signals) {
  const SystemClock clock;
  Supervisor supervisor(RestartLimits{}, clock, Say);
  BecomeSubreaper();
  for (ProcessSpec& spec : specs) DADRL_RETURN_IF_ERROR(supervisor.Start(std::move(spec)));
  bool stopping = false;
  bool failing = false;
  const auto update_episodes = [&] {
    const Status written = episodes.Update();
    if (!written && !std::exchange(failing, true)) Say(written.error().message);
    if (written) failing = false;
  };
  while (!supervisor.AllEnded()) {
    std::vector<pollfd> fds = {{.fd = signals.fd(), .events = POLLIN, .revents = 0}};
    supervisor.AppendWaitFds(fds);
    const auto wait = std::chrono::duration_cast<std::chrono::milliseconds>(supervisor.NextDeadline(kTick));
    poll(fds.data(), fds.size(), static_cast<int>(wait.count()));
    supervisor.Step();
    ReapAdopted(supervisor.RunningPids());
    update_episodes();
    if (signals.KillRequested()) supervisor.KillAll();
    if (signals.StopRequested() && !stopping) {
      stopping = true;
      supervisor.StopRole(kActorRole);
      Say("waiting for the actors to finish their step; once more Ctrl-C kills them");
    }
  }
  update_episodes();
  return supervisor.Lost() ? 1 : 0;
}

Result<int> RunJoin(const ActorOptions& options) {
  DADRL_ASSIGN_OR_RETURN(const std::unique_ptr<SignalWatcher> signals, SignalWatcher::Create());
  DADRL_ASSIGN_OR_RETURN(RunPlace place, ParseRunPlace(options.join));
  DADRL_ASSIGN_OR_RETURN(const Config own, options.config.Apply(Config{}));  // before anything waits
  place.mtu = own.cluster.mtu;
  DADRL_ASSIGN_OR_RETURN(place.key, Key(options, place.host));
  DADRL_ASSIGN_OR_RETURN(const Config run,
                         FindRun(place, kPatience, [&] { return signals->StopRequested(); }));
  DADRL_ASSIGN_OR_RETURN(const Config config, options.config.Apply(run));
  DADRL_RETURN_IF_ERROR(Validate(config));
  const auto root = options.run_dir.empty() ? NewRunPath("runs", "join-" + place.host)
                                            : std::filesystem::path(options.run_dir);
  DADRL_ASSIGN_OR_RETURN(const RunDirectory directory, RunDirectory::CreateNew(root));
  DADRL_RETURN_IF_ERROR(directory.SaveConfig(config));
  if (!place.key.empty()) DADRL_RETURN_IF_ERROR(SaveRunKey(root, place.key));
  const int first = options.first_index >= 0 ? options.first_index : DrawFirstIndex(options.actors);
  DADRL_ASSIGN_OR_RETURN(std::vector<ProcessSpec> specs,
                         ActorProcesses(directory.paths(), first, options.actors));
  fmt::print(stderr, "actors {} to {} join {}; logs in {}\n", first, first + options.actors - 1, options.join,
             directory.paths().logs().string());
  DADRL_ASSIGN_OR_RETURN(EpisodeLog episodes,
                         EpisodeLog::Open(directory.paths().episodes(), directory.paths().logs()));
  return RunActors(std::move(specs), std::move(episodes), *signals);
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
                  "Number of the first actor, unique in the cluster (default: drawn)")
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
