// The choice among a training's last policies: all drive the same traffic, kept for that, and the best is
// linked as checkpoints/best. Traffic that grades a policy never chooses it (kFirstValidationSeed,
// kFirstEvaluationSeed).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "common/util/result.h"
#include "deploy/local/run_directory.h"
#include "proto/evaluation/report.h"

namespace dadrl {

// A policy in a run's checkpoints folder.
struct SavedPolicy {
  std::filesystem::path file;
  uint64_t updates = 0;
  uint32_t policy_version = 0;
};

// The newest `count` policies of the run, the newest first; fewer when there are fewer. Damaged files are
// left out, each with a line to `warn`. kNotFound when none is left. Blocks on the disk.
Result<std::vector<SavedPolicy>> NewestPolicies(const RunPaths& paths, int count,
                                                const std::function<void(const std::string&)>& warn);

struct Candidate {
  SavedPolicy policy;
  EvaluationReport report;
};

// Whether `a` is to be preferred: more success, then fewer collisions. False when they are equal in both:
// then the newer policy is taken, not the faster one, which is often the one in a hurry (docs/results.md).
bool DrivesBetter(const EvaluationFigures& a, const EvaluationFigures& b);

struct Selection {
  std::string scenario;  // a name, or "all"
  uint64_t first_seed = 0;
  int episodes = 0;                   // that each candidate drove, in each scenario
  std::vector<Candidate> candidates;  // the newest first; at least one

  const Candidate& chosen() const;
};

// One JSON object with the candidates' figures, without a line break.
std::string SelectionJson(const Selection& selection);
// A line for each candidate; line break at the end.
std::string SelectionTable(const Selection& selection);
// "49,289 updates, best of 8 on traffic kept for that: success 98.0 %, ..."
std::string SelectionLine(const Selection& selection);

// Links checkpoints/best to the chosen policy, then writes selection.json.
Status SaveSelection(const RunPaths& paths, const Selection& selection);
// Links checkpoints/best to `newest`, without a choice.
Status TakeNewest(const RunPaths& paths, const SavedPolicy& newest);
// Removes what the two above wrote: training goes on, and the learner removes old policies.
void ForgetSelection(const RunPaths& paths);

}  // namespace dadrl
