#include "deploy/local/evaluation_job.h"

#include <algorithm>
#include <csignal>
#include <utility>

#include "common/config/config_schema.h"
#include "deploy/local/executables.h"

namespace dadrl {
namespace {

constexpr int kMaxAttempts = 2;
constexpr int kSlicesPerProcess = 4;
constexpr size_t kTailLines = 8;

// What is left of `slice` after its first `done` episodes.
EvaluationSlice Rest(const EvaluationSlice& slice, int done) {
  return {slice.group, slice.first_seed + static_cast<uint64_t>(done), slice.count - done};
}

}  // namespace

std::vector<EvaluationSlice> SliceEpisodes(const std::vector<PlannedEpisode>& episodes, int processes) {
  const int total = std::ssize(episodes);
  const int pieces = kSlicesPerProcess * std::max(1, processes);
  const int size = std::max(1, (total + pieces - 1) / pieces);
  std::vector<EvaluationSlice> slices;
  for (const PlannedEpisode& episode : episodes) {
    const bool fits = !slices.empty() && slices.back().group == episode.group && slices.back().count < size &&
                      slices.back().first_seed + static_cast<uint64_t>(slices.back().count) == episode.seed;
    if (!fits) slices.push_back({episode.group, episode.seed, 0});
    ++slices.back().count;
  }
  return slices;
}

Result<EvaluationJob> EvaluationJob::Create(EvaluationPlan plan) {
  DADRL_ASSIGN_OR_RETURN(const auto episodes, PlanEpisodes(plan.first_seed, plan.groups, plan.episodes));
  EvaluationJob job(std::move(plan));
  const std::vector<std::string> scenarios =
      job.plan_.scenario == kAllScenarios ? ScenarioNames() : std::vector{job.plan_.scenario};
  job.planned_ = episodes.size() * scenarios.size();
  for (const std::string& scenario : scenarios) {
    for (const EvaluationSlice& slice : SliceEpisodes(episodes, job.plan_.processes)) {
      job.waiting_.push_back({scenario, slice});
    }
  }
  std::reverse(job.waiting_.begin(), job.waiting_.end());
  return job;
}

void EvaluationJob::AppendWaitFds(std::vector<pollfd>& fds) const {
  for (const Worker& worker : running_) {
    fds.push_back({.fd = worker.process.child().pidfd(), .events = POLLIN, .revents = 0});
  }
}

std::vector<pid_t> EvaluationJob::RunningPids() const {
  std::vector<pid_t> pids;
  for (const Worker& worker : running_) pids.push_back(worker.process.child().pid());
  return pids;
}

Result<EvaluationJob::Worker> EvaluationJob::Launch(const Waiting& next) const {
  std::vector<std::string> command = {
      plan_.program, "evaluate",
      "--policy",    plan_.policy,
      "--scenario",  next.scenario,
      "--seeds",     fmt::format("{}:{}", next.slice.first_seed, next.slice.count)};
  if (!plan_.config.empty()) command.insert(command.end(), {"--config", plan_.config});
  command.insert(command.end(), plan_.policy_arguments.begin(), plan_.policy_arguments.end());
  DADRL_ASSIGN_OR_RETURN(CapturedProcess process,
                         CapturedProcess::Spawn(std::move(command), plan_.nice, plan_.hang_limits));
  return Worker{next.scenario, next.slice, next.attempts + 1, std::move(process), {}};
}

void EvaluationJob::KillIfHung(Worker& worker) const {
  if (!worker.hung.empty()) return;
  const std::optional<std::string> why = worker.process.Hangs();
  if (!why) return;
  worker.hung = *why;
  worker.process.child().Signal(SIGKILL);
  if (!plan_.notice) return;
  plan_.notice(
      fmt::format("an evaluation's process (pid {}) hangs: {}; it is killed, its episodes are driven again",
                  worker.process.child().pid(), *why));
}

void EvaluationJob::Step() {
  for (size_t i = 0; i < running_.size();) {
    if (running_[i].process.Overflows()) {
      error_ = Error{ErrorCode::kInternal,
                     fmt::format("{} printed more than {} bytes: it is not the program that evaluates",
                                 plan_.program.string(), kMaxCapturedBytes)};
      break;
    }
    const auto status = running_[i].process.child().TryWait();
    if (!status) {
      KillIfHung(running_[i]);
      ++i;
      continue;
    }
    Worker ended = std::move(running_[i]);
    running_.erase(running_.begin() + static_cast<std::ptrdiff_t>(i));
    Gather(ended, *status);
  }
  while (!error_ && !waiting_.empty() && std::ssize(running_) < plan_.processes) {
    const Waiting next = waiting_.back();
    waiting_.pop_back();
    Result<Worker> worker = Launch(next);
    if (worker) {
      running_.push_back(std::move(*worker));
    } else {
      error_ = worker.error();
    }
  }
  if (error_) running_.clear();
}

void EvaluationJob::Gather(Worker& worker, const ExitStatus& status) {
  int done = 0;
  for (const std::string& line : worker.process.OutputLines()) {
    Result<EvaluatedEpisode> episode = ParseEpisodeLine(line);
    const uint64_t expected = worker.slice.first_seed + static_cast<uint64_t>(done);
    if (!episode || episode->summary.seed != expected || done == worker.slice.count) {
      error_ = Error{
          ErrorCode::kInternal,
          fmt::format("{} printed what is not the result of seed {}: {}", plan_.program.string(), expected,
                      episode ? fmt::format("seed {}", episode->summary.seed) : episode.error().message)};
      return;
    }
    episode->group = worker.slice.group;
    episode->summary.scenario = worker.scenario;
    episodes_.push_back(std::move(*episode));
    ++done;
  }
  if (done == worker.slice.count) return;
  HandleDeath(worker, status, done);
}

void EvaluationJob::HandleDeath(const Worker& worker, const ExitStatus& status, int done) {
  const EvaluationSlice rest = Rest(worker.slice, done);
  const bool refused = !status.signaled && status.value == 2;
  // One retry for each episode: progress starts the count anew.
  const int attempts = done > 0 ? 1 : worker.attempts;
  if (!refused && attempts < kMaxAttempts) {
    waiting_.push_back({worker.scenario, rest, attempts});
    return;
  }
  const std::string last_message = worker.process.LastMessage();
  if (status.signaled) {
    // The simulator aborts on this traffic: the episode is lost, the evaluation is not.
    EvaluatedEpisode lost;
    lost.group = rest.group;
    lost.summary.scenario = worker.scenario;
    lost.summary.seed = rest.first_seed;
    lost.error =
        worker.hung.empty()
            ? fmt::format("its process ended twice, last with {}: {}", status.Describe(), last_message)
            : fmt::format("its process was lost twice, the last hung: {}", worker.hung);
    episodes_.push_back(std::move(lost));
    if (rest.count > 1) waiting_.push_back({worker.scenario, Rest(rest, 1), 0});
    return;
  }
  if (refused && !last_message.empty()) {
    error_ = Error{ErrorCode::kInvalidArgument, last_message};
    return;
  }
  std::string message = fmt::format("evaluation failed at seed {} ({})", rest.first_seed, status.Describe());
  for (const std::string& line : worker.process.LogEnd(kTailLines)) message += "\n  | " + line;
  error_ = Error{ErrorCode::kInternal, std::move(message)};
}

int EvaluationJob::finished_episodes() const {
  int count = std::ssize(episodes_);
  for (const Worker& worker : running_) count += worker.process.OutputLineCount();
  return count;
}

Result<EvaluationReport> EvaluationJob::TakeReport() {
  if (error_) return tl::unexpected<Error>(*error_);
  EvaluationReport report = MakeReport(plan_.scenario, plan_.policy_label, std::move(episodes_));
  if (report.all.episodes == 0) {
    return Fail(ErrorCode::kInternal, "the simulator lost all {} episodes; the first: {}", report.lost,
                report.episodes.empty() ? "" : report.episodes.front().error);
  }
  return report;
}

}  // namespace dadrl
