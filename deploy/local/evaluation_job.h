// An evaluation spread over processes: each drives a range of traffic seeds and prints a line an episode.
#pragma once

#include <poll.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/util/result.h"
#include "deploy/local/captured_process.h"
#include "proto/evaluation/report.h"

namespace dadrl {

struct EvaluationPlan {
  std::filesystem::path program;              // dadrl-actor, or what speaks its line protocol
  std::string policy;                         // policy file or a scripted driver's name
  std::string policy_label;                   // how the report calls it
  std::vector<std::string> policy_arguments;  // of a scripted driver, passed on
  std::string scenario;                       // a name, or "all": every episode in each of them
  std::filesystem::path config;               // passed on as --config; empty: none
  uint64_t first_seed = kFirstEvaluationSeed;
  int groups = 1;
  int episodes = 50;  // of each group
  int processes = 1;
  int nice = 0;
  HangLimits hang_limits;
  // One line about what went wrong on the way and did not end the evaluation; may be empty.
  std::function<void(const std::string&)> notice;
};

// Consecutive seeds of one group: the work of one process.
struct EvaluationSlice {
  int group = 0;
  uint64_t first_seed = 0;
  int count = 0;
  bool operator==(const EvaluationSlice&) const = default;
};

// Cuts `episodes` (ordered, as PlanEpisodes gives them) into slices, about four for each process so that all
// end at about the same time.
std::vector<EvaluationSlice> SliceEpisodes(const std::vector<PlannedEpisode>& episodes, int processes);

// Runs the plan; nothing blocks: the owner polls AppendWaitFds and calls Step. Destroyed early: its processes
// are killed. Not thread safe; same thread rule as ChildProcess.
class EvaluationJob {
 public:
  // kInvalidArgument as PlanEpisodes.
  static Result<EvaluationJob> Create(EvaluationPlan plan);

  void AppendWaitFds(std::vector<pollfd>& fds) const;
  // Reaps, gathers, starts what is next.
  void Step();

  bool done() const { return error_.has_value() || (running_.empty() && waiting_.empty()); }
  int finished_episodes() const;
  int planned_episodes() const { return planned_; }
  std::vector<pid_t> RunningPids() const;

  // After done(): the report, or why there is none. Episodes that a process left undone are tried once more;
  // a process that hangs is killed. One that kills its process twice is reported as lost; an error that comes
  // twice ends the evaluation and shows the end of what was logged.
  Result<EvaluationReport> TakeReport();

 private:
  struct Worker {
    std::string scenario;
    EvaluationSlice slice;
    int attempts = 1;
    CapturedProcess process;
    std::string hung;  // why it was killed
  };
  struct Waiting {
    std::string scenario;
    EvaluationSlice slice;
    int attempts = 0;
  };

  explicit EvaluationJob(EvaluationPlan plan) : plan_(std::move(plan)) {}
  Result<Worker> Launch(const Waiting& next) const;
  void KillIfHung(Worker& worker) const;
  // Takes over the episodes of an ended worker; queues or reports what is missing.
  void Gather(Worker& worker, const ExitStatus& status);
  // The worker ended after `done` of its episodes.
  void HandleDeath(const Worker& worker, const ExitStatus& status, int done);

  EvaluationPlan plan_;
  int planned_ = 0;
  std::vector<Waiting> waiting_;  // the last is next
  std::vector<Worker> running_;
  std::vector<EvaluatedEpisode> episodes_;
  std::optional<Error> error_;
};

}  // namespace dadrl
