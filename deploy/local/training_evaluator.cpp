#include "deploy/local/training_evaluator.h"

#include <algorithm>
#include <utility>

#include "common/io/link_file.h"
#include "common/io/read_file.h"
#include "common/model/policy_file.h"
#include "common/util/resources.h"
#include "deploy/local/executables.h"

namespace dadrl {
namespace {

// While training the evaluation takes what the cluster leaves over.
constexpr int kInterimNice = 10;

}  // namespace

TrainingEvaluator::TrainingEvaluator(RunPaths paths, const Config& config,
                                     std::function<void(const std::string&)> message)
    : paths_(std::move(paths)), config_(config), message_(std::move(message)) {}

Status TrainingEvaluator::StartInterim() { return StartEvaluation(paths_.policy(), false); }

Status TrainingEvaluator::StartFinal() {
  DADRL_ASSIGN_OR_RETURN(std::vector<SavedPolicy> candidates,
                         NewestPolicies(paths_, config_.evaluation.candidates, message_));
  if (config_.evaluation.candidates == 1) {
    DADRL_RETURN_IF_ERROR(TakeNewest(paths_, candidates.front()));
    return StartEvaluation(paths_.best_policy(), true);
  }
  DADRL_ASSIGN_OR_RETURN(const std::filesystem::path program, FindExecutable("dadrl-actor"));
  DADRL_ASSIGN_OR_RETURN(
      SelectionJob job,
      SelectionJob::Create({.program = program,
                            .scenario = config_.scenario,
                            .config = paths_.config(),
                            .episodes = config_.evaluation.candidate_episodes,
                            .processes = std::max(UsableCores(), config_.evaluation.processes),
                            .hang_limits = HangLimits::Of(config_.cluster),
                            .notice = message_,
                            .candidates = std::move(candidates)}));
  selection_.emplace(std::move(job));
  return {};
}

Status TrainingEvaluator::StartEvaluation(const std::filesystem::path& policy_file, bool final) {
  DADRL_ASSIGN_OR_RETURN(const std::vector<std::byte> bytes,
                         ReadFile(FollowLinks(policy_file), kMaxPolicyBytes, Links::kFollow));
  DADRL_ASSIGN_OR_RETURN(copy_, SharedFile::Create("policy", bytes));
  DADRL_ASSIGN_OR_RETURN(const PolicyFile policy, LoadPolicy(copy_->path()));
  DADRL_ASSIGN_OR_RETURN(const std::filesystem::path program, FindExecutable("dadrl-actor"));
  DADRL_ASSIGN_OR_RETURN(
      EvaluationJob job,
      EvaluationJob::Create(
          {.program = program,
           .policy = copy_->path(),
           .policy_label = fmt::format("{}@{}", paths_.root.filename().string(), policy.updates),
           .policy_arguments = {},
           .scenario = config_.scenario,
           .config = paths_.config(),
           .first_seed = final ? kFirstEvaluationSeed : kFirstValidationSeed,
           .episodes = config_.evaluation.episodes,
           .processes =
               final ? std::max(UsableCores(), config_.evaluation.processes) : config_.evaluation.processes,
           .nice = final ? 0 : kInterimNice,
           .hang_limits = HangLimits::Of(config_.cluster),
           .notice = message_}));
  evaluation_.emplace(std::move(job));
  final_ = final;
  evaluated_ = {policy_file, policy.updates, policy.policy_version};
  return {};
}

void TrainingEvaluator::Cancel() {
  selection_.reset();
  evaluation_.reset();
}

void TrainingEvaluator::AppendWaitFds(std::vector<pollfd>& fds) const {
  if (selection_) selection_->AppendWaitFds(fds);
  if (evaluation_) evaluation_->AppendWaitFds(fds);
}

std::vector<pid_t> TrainingEvaluator::RunningPids() const {
  if (selection_) return selection_->RunningPids();
  if (evaluation_) return evaluation_->RunningPids();
  return {};
}

std::optional<Result<EvaluatedPolicy>> TrainingEvaluator::Step() {
  if (selection_) {
    selection_->Step();
    if (!selection_->done()) return std::nullopt;
    if (Status chosen = FinishSelection(); !chosen) return tl::unexpected<Error>(std::move(chosen.error()));
    return std::nullopt;
  }
  if (!evaluation_) return std::nullopt;
  evaluation_->Step();
  if (!evaluation_->done()) return std::nullopt;
  Result<EvaluationReport> report = evaluation_->TakeReport();
  evaluation_.reset();
  if (unsaved_) {
    // The last word: a training whose choice is nowhere has not ended well.
    if (Status saved = SaveSelection(paths_, *unsaved_); !saved) {
      return tl::unexpected<Error>(std::move(saved.error()));
    }
  }
  return std::move(report).map([&](EvaluationReport&& whole) {
    return EvaluatedPolicy{evaluated_.updates, evaluated_.policy_version, std::move(whole)};
  });
}

Status TrainingEvaluator::FinishSelection() {
  const Result<Selection> selection = selection_->TakeSelection();
  selection_.reset();
  if (!selection) return tl::unexpected<Error>(selection.error());
  message_("chosen: " + SelectionLine(*selection));
  if (const Status saved = SaveSelection(paths_, *selection); !saved) {
    message_(saved.error().message + "; tried again after the evaluation");
    unsaved_ = *selection;
  }
  return StartEvaluation(selection->chosen().policy.file, true);
}

std::string TrainingEvaluator::Progress() const {
  if (selection_) {
    return fmt::format("choosing among {} policies: {} of {} episodes", selection_->candidates(),
                       selection_->finished_episodes(), selection_->planned_episodes());
  }
  if (!evaluation_) return "";
  return fmt::format("{}: {} of {} episodes", final_ ? "final evaluation" : "evaluation",
                     evaluation_->finished_episodes(), evaluation_->planned_episodes());
}

}  // namespace dadrl
