// Drives the candidates of a selection, one after the other, each with all processes.
#pragma once

#include <poll.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/util/result.h"
#include "deploy/local/evaluation_job.h"
#include "deploy/local/policy_selection.h"

namespace dadrl {

struct SelectionPlan {
  std::filesystem::path program;  // dadrl-actor, or what speaks its line protocol
  std::string scenario;           // a name, or "all": every episode in each of them
  std::filesystem::path config;   // passed on as --config; empty: none
  int episodes = 100;             // of each candidate, of each scenario: traffic from kFirstValidationSeed
  int processes = 1;
  HangLimits hang_limits;
  std::function<void(const std::string&)> notice;  // as EvaluationPlan's
  std::vector<SavedPolicy> candidates;  // the newest first; at least one; nobody removes them meanwhile
};

// Nothing blocks: the owner polls AppendWaitFds and calls Step, as with EvaluationJob; same thread rule.
class SelectionJob {
 public:
  // kInvalidArgument as EvaluationJob::Create.
  static Result<SelectionJob> Create(SelectionPlan plan);

  void AppendWaitFds(std::vector<pollfd>& fds) const { current_->AppendWaitFds(fds); }
  void Step();
  bool done() const { return error_.has_value() || driven_.size() == plan_.candidates.size(); }
  size_t candidates() const { return plan_.candidates.size(); }
  int finished_episodes() const;
  int planned_episodes() const;
  std::vector<pid_t> RunningPids() const { return current_->RunningPids(); }

  // After done(): what every candidate did, or why one could not be evaluated.
  Result<Selection> TakeSelection();

 private:
  explicit SelectionJob(SelectionPlan plan) : plan_(std::move(plan)) {}
  // Begins the evaluation of the first candidate not yet driven.
  Status Begin();

  SelectionPlan plan_;
  std::optional<EvaluationJob> current_;  // always there after Create
  std::vector<Candidate> driven_;
  std::optional<Error> error_;
};

}  // namespace dadrl
