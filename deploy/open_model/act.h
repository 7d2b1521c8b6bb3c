// What a policy file's networks say about recorded observations.
#pragma once

#include <string>
#include <vector>

#include "common/model/policy_file.h"
#include "common/model/value_model.h"
#include "common/util/result.h"

namespace dadrl {

// Row i belongs to observation i.
struct ActReport {
  struct Numbers {
    std::string name;
    std::vector<std::vector<float>> rows;
  };
  std::vector<Numbers> numbers;            // what the policy says (PolicyModel::Details::numbers)
  std::vector<Action> action;              // the likeliest
  std::vector<ValueModel::Values> values;  // of observation and action, by the policy and every other network
  std::vector<std::vector<float>> attention;  // [vehicles]; rows are empty where the policy attends to none
};

// The policy by the actors' single-observation path, as one episode; the other networks by the batched one.
// kInvalidArgument or kCorrupt when the file is of other networks or not finite; `path` names it.
Result<ActReport> ActOn(const Columns& observations, const PolicyFile& policy,
                        const std::filesystem::path& path);

// One JSON object: an array for each name there is, and attention, null where there is none.
std::string ActJson(const ActReport& report);
// A line an observation.
std::string ActTable(const ActReport& report);

}  // namespace dadrl
