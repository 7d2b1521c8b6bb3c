// Trained policies that come with the program: NAME.dadrl, and NAME.json on where it comes from (written by
// deploy/results/record_run.py --ship).
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/util/result.h"

namespace dadrl {

struct ShippedPolicy {
  std::string name;
  std::filesystem::path file;
  nlohmann::ordered_json record;  // an empty object when NAME.json is missing or damaged
};

// $DADRL_POLICIES, else ../share/dadrl/policies beside the folder of this program.
std::filesystem::path PolicyFolder();

// All of them by name; empty when there is no folder.
std::vector<ShippedPolicy> ShippedPolicies();

// "pretrained:NAME" as the path of its file; any other text as it is. kInvalidArgument with the nearest name
// and all of them when none is called so.
Result<std::string> ResolvePolicy(const std::string& policy);

}  // namespace dadrl
