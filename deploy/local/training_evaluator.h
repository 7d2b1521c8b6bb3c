// What a training evaluates: its newest policy now and then, and at its end the best of its last ones.
#pragma once

#include <poll.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/util/result.h"
#include "deploy/local/evaluation_job.h"
#include "deploy/local/run_directory.h"
#include "deploy/local/selection_job.h"
#include "deploy/local/shared_file.h"

namespace dadrl {

struct EvaluatedPolicy {
  uint64_t updates = 0;
  uint32_t policy_version = 0;
  EvaluationReport report;
};

// One evaluation at a time. Nothing blocks but reading a policy file: the owner polls
// AppendWaitFds and calls Step. Same thread rule as ChildProcess.
class TrainingEvaluator {
 public:
  // `message` is told what a user wants to know on the way. The paths and the configuration (that of the run
  // directory) are copied.
  TrainingEvaluator(RunPaths paths, const Config& config, std::function<void(const std::string&)> message);

  // Of the newest policy, on validation traffic, with what the cluster leaves over. An error: there is no
  // policy, or no way to evaluate it.
  Status StartInterim();
  // Chooses among the newest `evaluation.candidates` policies (checkpoints/best, selection.json), then
  // evaluates the chosen one on the traffic that grades it. Only when the learner has ended: candidates must
  // stay.
  Status StartFinal();

  bool running() const { return selection_.has_value() || evaluation_.has_value(); }
  // Its processes are killed.
  void Cancel();
  void AppendWaitFds(std::vector<pollfd>& fds) const;
  std::vector<pid_t> RunningPids() const;
  // Once for each start: the result, in the step in which it is there.
  std::optional<Result<EvaluatedPolicy>> Step();
  // "choosing among 8 policies: 120 of 800 episodes"; empty when nothing is running.
  std::string Progress() const;

 private:
  Status StartEvaluation(const std::filesystem::path& policy, bool final);
  // The candidates have driven: saves the choice and goes on to the chosen one.
  Status FinishSelection();

  const RunPaths paths_;
  const Config config_;
  const std::function<void(const std::string&)> message_;
  std::optional<SelectionJob> selection_;
  std::optional<EvaluationJob> evaluation_;
  bool final_ = false;  // which kind `evaluation_` is
  // A copy of the policy that is evaluated, however long that takes: the learner removes old ones.
  std::optional<SharedFile> copy_;
  std::optional<Selection> unsaved_;  // a choice that could not be written down yet
  SavedPolicy evaluated_;
};

}  // namespace dadrl
