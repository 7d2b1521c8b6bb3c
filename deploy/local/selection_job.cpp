#include "deploy/local/selection_job.h"

#include <utility>

namespace dadrl {

Result<SelectionJob> SelectionJob::Create(SelectionPlan plan) {
  SelectionJob job(std::move(plan));
  DADRL_RETURN_IF_ERROR(job.Begin());
  return job;
}

Status SelectionJob::Begin() {
  const SavedPolicy& policy = plan_.candidates[driven_.size()];
  DADRL_ASSIGN_OR_RETURN(EvaluationJob job, EvaluationJob::Create({.program = plan_.program,
                                                                   .policy = policy.file,
                                                                   .policy_label = policy.file.filename(),
                                                                   .policy_arguments = {},
                                                                   .scenario = plan_.scenario,
                                                                   .config = plan_.config,
                                                                   .first_seed = kFirstValidationSeed,
                                                                   .groups = 1,
                                                                   .episodes = plan_.episodes,
                                                                   .processes = plan_.processes,
                                                                   .hang_limits = plan_.hang_limits,
                                                                   .notice = plan_.notice}));
  current_.emplace(std::move(job));
  return {};
}

void SelectionJob::Step() {
  if (done()) return;
  current_->Step();
  if (!current_->done()) return;
  Result<EvaluationReport> report = current_->TakeReport();
  if (!report) {
    error_ = std::move(report.error());
    return;
  }
  driven_.push_back({plan_.candidates[driven_.size()], std::move(*report)});
  if (done()) return;
  if (Status begun = Begin(); !begun) error_ = std::move(begun.error());
}

int SelectionJob::finished_episodes() const {
  const int each = current_->planned_episodes();
  // The current one is the last that was driven once all are.
  const bool between = driven_.size() == plan_.candidates.size();
  return each * std::ssize(driven_) + (between ? 0 : current_->finished_episodes());
}

int SelectionJob::planned_episodes() const {
  return current_->planned_episodes() * std::ssize(plan_.candidates);
}

Result<Selection> SelectionJob::TakeSelection() {
  if (error_) return tl::unexpected<Error>(*error_);
  return Selection{.scenario = plan_.scenario,
                   .first_seed = kFirstValidationSeed,
                   .episodes = plan_.episodes,
                   .candidates = driven_};
}

}  // namespace dadrl
