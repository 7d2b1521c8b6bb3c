// Policy files in a run's checkpoints folder, without a training.
#pragma once

#include <gtest/gtest.h>

#include <array>

#include "common/config/config_yaml.h"
#include "common/model/policy_file.h"
#include "deploy/local/policy_selection.h"

namespace dadrl {

// checkpoints/policy-<updates>.dadrl: whole, but with too few parameters to drive.
inline SavedPolicy SavePolicyAt(const RunPaths& paths, uint64_t updates) {
  constexpr std::array<float, 2> kParameters = {0.5F, -0.5F};
  std::filesystem::create_directories(paths.checkpoints());
  const auto file = paths.checkpoints() / fmt::format("policy-{:09}.dadrl", updates);
  EXPECT_TRUE(SavePolicy(file, {.policy_version = static_cast<uint32_t>(updates / 10),
                                .updates = updates,
                                .config_yaml = ToYaml(Config{}, false),
                                .networks = {{kPolicyNetwork, 1, kParameters}}}));
  return {file, updates, static_cast<uint32_t>(updates / 10)};
}

}  // namespace dadrl
