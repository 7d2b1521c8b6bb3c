#include "deploy/local/policy_selection.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "common/io/atomic_file.h"
#include "common/io/link_file.h"
#include "common/model/policy_file.h"
#include "deploy/local/build_info.h"
#include "deploy/monitor/bottleneck.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::vector<fs::path> PolicyFiles(const fs::path& checkpoints) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(checkpoints, error)) {
    const std::string name = entry.path().filename();
    // The links `latest` and `best` name no further policy.
    if (name.starts_with("policy-") && name.ends_with(".dadrl")) files.push_back(entry.path());
  }
  // The updates in the names are zero-padded.
  std::ranges::sort(files, std::ranges::greater());
  return files;
}

std::string Row(const std::string& updates, const std::string& success, const std::string& collision,
                const std::string& off_road, const std::string& stagnation, const std::string& steps,
                const std::string& mark = "") {
  const std::string row = fmt::format("{:>12} {:>9} {:>9} {:>9} {:>10} {:>7}", updates, success, collision,
                                      off_road, stagnation, steps);
  return row + (mark.empty() ? "\n" : "  " + mark + "\n");
}

std::string Percent(double rate) { return fmt::format("{:.1f}", 100 * rate); }

}  // namespace

Result<std::vector<SavedPolicy>> NewestPolicies(const RunPaths& paths, int count,
                                                const std::function<void(const std::string&)>& warn) {
  std::vector<SavedPolicy> policies;
  for (const fs::path& file : PolicyFiles(paths.checkpoints())) {
    if (std::ssize(policies) == count) break;
    const auto policy = LoadPolicy(file);
    if (policy) {
      policies.push_back({file, policy->updates, policy->policy_version});
    } else {
      warn(fmt::format("left out: {}", policy.error().message));
    }
  }
  if (policies.empty()) {
    return Fail(
        ErrorCode::kNotFound,
        "{} holds no whole policy: train for longer than learner.checkpoint_interval_s, or until the end",
        paths.checkpoints().string());
  }
  return policies;
}

bool DrivesBetter(const EvaluationFigures& a, const EvaluationFigures& b) {
  return std::pair(-a.success, a.collision) < std::pair(-b.success, b.collision);
}

const Candidate& Selection::chosen() const {
  // The first of equals: the newest.
  return *std::ranges::min_element(candidates, [](const Candidate& a, const Candidate& b) {
    return DrivesBetter(a.report.all, b.report.all);
  });
}

std::string SelectionJson(const Selection& selection) {
  Json rows = Json::array();
  for (const Candidate& candidate : selection.candidates) {
    Json row = {{"file", candidate.policy.file.filename().string()},
                {"updates", candidate.policy.updates},
                {"policy_version", candidate.policy.policy_version}};
    row.update(Json::parse(ReportJson(candidate.report)));
    for (const char* known : {"scenario", "policy", "per_seed"}) row.erase(known);
    rows.push_back(std::move(row));
  }
  const SavedPolicy& chosen = selection.chosen().policy;
  const Json json = {{"scenario", selection.scenario}, {"chosen", chosen.file.filename().string()},
                     {"updates", chosen.updates},      {"first_seed", selection.first_seed},
                     {"episodes", selection.episodes}, {"commit", BuildCommit()},
                     {"candidates", std::move(rows)}};
  return json.dump();
}

std::string SelectionTable(const Selection& selection) {
  std::string text = fmt::format("{}: {} episodes each, traffic seeds {} to {}\n", selection.scenario,
                                 selection.candidates.front().report.episodes.size(), selection.first_seed,
                                 selection.first_seed + static_cast<uint64_t>(selection.episodes) - 1);
  text += Row("updates", "success %", "collision", "off-road", "stagnation", "steps");
  for (const Candidate& candidate : selection.candidates) {
    const EvaluationFigures& all = candidate.report.all;
    std::string mark = &candidate == &selection.chosen() ? "chosen" : "";
    if (candidate.report.lost > 0) {
      mark += fmt::format("{}{} lost to the simulator", mark.empty() ? "" : "; ", candidate.report.lost);
    }
    text +=
        Row(Thousands(candidate.policy.updates), Percent(all.success), Percent(all.collision),
            Percent(all.off_road), Percent(all.stagnation), fmt::format("{:.0f}", all.median_steps), mark);
  }
  return text;
}

std::string SelectionLine(const Selection& selection) {
  const Candidate& chosen = selection.chosen();
  return fmt::format(
      "{} updates, best of {} on traffic kept for that: success {:.1f} %, collision {:.1f} % of "
      "{} episodes",
      Thousands(chosen.policy.updates), selection.candidates.size(), 100 * chosen.report.all.success,
      100 * chosen.report.all.collision, chosen.report.all.episodes);
}

Status SaveSelection(const RunPaths& paths, const Selection& selection) {
  DADRL_RETURN_IF_ERROR(LinkAtomically(paths.best_policy(), selection.chosen().policy.file.filename()));
  return WriteFileAtomically(paths.selection(), std::string_view(SelectionJson(selection) + "\n"));
}

Status TakeNewest(const RunPaths& paths, const SavedPolicy& newest) {
  ForgetSelection(paths);
  return LinkAtomically(paths.best_policy(), newest.file.filename());
}

void ForgetSelection(const RunPaths& paths) {
  std::error_code ignored;  // a record without its link is refused by its readers
  fs::remove(paths.selection(), ignored);
  fs::remove(paths.best_policy(), ignored);
}

}  // namespace dadrl
