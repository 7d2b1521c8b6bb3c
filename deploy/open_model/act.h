// What a policy file's networks say about recorded observations.
#pragma once

#include <string>
#include <vector>

#include "common/model/policy_file.h"
#include "common/step/driving_shape.h"
#include "common/util/result.h"

namespace dadrl {

// Row i belongs to observation i.
struct ActReport {
  std::vector<Action> mean;     // before tanh
  std::vector<Action> log_std;  // clamped
  std::vector<Action> action;   // tanh(mean), the deterministic policy's
  std::vector<float> q1;        // of observation and action; empty when the file has no critics
  std::vector<float> q2;
  std::vector<std::vector<float>> attention;  // [vehicles]; rows are empty without STAE
};

// The policy by the actors' single-observation path, the critics by the learner's batched one.
// kInvalidArgument or kCorrupt when the file is of other networks or not finite; `path` names it.
Result<ActReport> ActOn(const Columns& observations, const PolicyFile& policy,
                        const std::filesystem::path& path);

// One JSON object; q1, q2 and attention are null where there are none.
std::string ActJson(const ActReport& report);
// A line an observation.
std::string ActTable(const ActReport& report);

}  // namespace dadrl
