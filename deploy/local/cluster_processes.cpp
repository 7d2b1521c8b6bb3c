#include "deploy/local/cluster_processes.h"

#include <filesystem>
#include <utility>

#include "deploy/local/executables.h"

namespace dadrl {
namespace {

// Where cores are scarce the learner comes first: experience is plenty, updates are not.
constexpr int kActorNice = 5;

using Arguments = std::vector<std::string>;

ProcessSpec Spec(const RunPaths& paths, std::string name, const char* role, Arguments arguments) {
  ProcessSpec spec;
  spec.log = paths.logs() / (name + ".log");
  spec.name = std::move(name);
  spec.role = role;
  spec.command = [arguments = std::move(arguments)](bool) { return arguments; };
  return spec;
}

Arguments Common(const std::filesystem::path& program, const RunPaths& paths) {
  return {program, "--config", paths.config(), "--run-dir", paths.root};
}

}  // namespace

Result<std::vector<ProcessSpec>> ActorProcesses(const RunPaths& paths, int first, int count,
                                                ActorNumbers numbers) {
  DADRL_ASSIGN_OR_RETURN(const auto program, FindExecutable("dadrl-actor"));
  std::vector<ProcessSpec> specs;
  for (int index = first; index < first + count; ++index) {
    Arguments arguments = {program,     "collect",  "--config", paths.config(),
                           "--run-dir", paths.root, "--index",  std::to_string(index)};
    if (numbers == ActorNumbers::kGiven) arguments.emplace_back("--any-number");
    ProcessSpec spec = Spec(paths, fmt::format("actor-{}", index), kActorRole, std::move(arguments));
    spec.expendable = true;
    spec.nice = kActorNice;
    specs.push_back(std::move(spec));
  }
  return specs;
}

Result<std::vector<ProcessSpec>> ClusterProcesses(const RunPaths& paths, const Config& config) {
  DADRL_ASSIGN_OR_RETURN(const auto replay_program, FindExecutable("dadrl-replay"));
  DADRL_ASSIGN_OR_RETURN(const auto learner_program, FindExecutable("dadrl-learner"));
  std::vector<ProcessSpec> specs;
  for (int shard = 0; shard < config.replay.shards; ++shard) {
    Arguments arguments = Common(replay_program, paths);
    arguments.insert(arguments.end(), {"--shard", std::to_string(shard)});
    specs.push_back(Spec(paths, fmt::format("replay-{}", shard), kReplayRole, std::move(arguments)));
    specs.back().stop_grace = std::chrono::seconds(30);
  }
  ProcessSpec learner = Spec(paths, "learner", kLearnerRole, {});
  learner.command = [arguments = Common(learner_program, paths)](bool restart) {
    Arguments result = arguments;
    if (restart) result.emplace_back("--resume");
    return result;
  };
  learner.may_finish = true;
  learner.stop_grace = std::chrono::seconds(60);  // its last checkpoint
  specs.push_back(std::move(learner));
  DADRL_ASSIGN_OR_RETURN(std::vector<ProcessSpec> actors, ActorProcesses(paths, 0, config.actor.count));
  for (ProcessSpec& actor : actors) specs.push_back(std::move(actor));
  return specs;
}

}  // namespace dadrl
