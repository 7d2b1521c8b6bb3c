#include "actor/evaluation/evaluation.h"

#include <cstdio>
#include <utility>

#include "common/liveness/working_thread.h"

namespace dadrl {

Result<EpisodeSummary> DriveEpisode(DrivingEnvironment& environment, DrivingPolicy& policy, uint64_t seed) {
  DADRL_RETURN_IF_ERROR(environment.Reset(seed));
  policy.BeginEpisode(seed);
  for (;;) {
    const Decision decision = policy.Decide(environment);
    DADRL_ASSIGN_OR_RETURN(const StepResult step, environment.Drive(decision.command, decision.steps));
    if (step.ended()) return environment.summary();
  }
}

std::vector<EvaluatedEpisode> DriveEpisodes(DrivingEnvironment& environment, DrivingPolicy& policy,
                                            const std::vector<PlannedEpisode>& plan,
                                            const OnEpisode& on_episode) {
  const WorkingThread working("evaluate");
  std::vector<EvaluatedEpisode> episodes;
  for (const PlannedEpisode& planned : plan) {
    EvaluatedEpisode episode;
    episode.group = planned.group;
    if (const auto driven = DriveEpisode(environment, policy, planned.seed)) {
      episode.summary = *driven;
    } else {
      episode.summary.scenario = environment.config().scenario;
      episode.summary.seed = planned.seed;
      episode.error = driven.error().message;
    }
    episodes.push_back(episode);
    if (on_episode && !on_episode(episode)) break;
  }
  return episodes;
}

Result<EvaluationReport> RunEvaluation(const EvaluationOptions& options) {
  DADRL_ASSIGN_OR_RETURN(const PolicySetup setup,
                         MakePolicy(options.policy, options.config, options.policy_options));
  DADRL_ASSIGN_OR_RETURN(const std::unique_ptr<DrivingEnvironment> environment,
                         DrivingEnvironment::Create(setup.config, setup.environment));
  EvaluationReport report =
      MakeReport(setup.config.scenario, options.policy,
                 DriveEpisodes(*environment, *setup.policy, options.episodes, options.on_episode));
  if (report.lost > 0 && report.all.episodes == 0) {
    return Fail(ErrorCode::kInternal, "the simulator lost all {} episodes; the first: {}", report.lost,
                report.episodes.front().error);
  }
  return report;
}

bool PrintLine(std::string line) {
  line += '\n';
  return std::fwrite(line.data(), 1, line.size(), stdout) == line.size() && std::fflush(stdout) == 0;
}

}  // namespace dadrl
