// A policy on disk, complete in itself: parameters and the configuration that gives them meaning. What
// `dadrl evaluate --policy` reads.
//
// File, little endian: "DADRLPOL" | u32 format | u32 policy version | u64 updates | u64 layout hash |
// u32 length, configuration as YAML | u64 count, float32[count] policy | u64 count, float32[count] critics
// (not in format 1) | xxh3-64 of everything before.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/util/result.h"

namespace dadrl {

// No policy is longer: sixteen times the largest networks that a configuration allows.
constexpr uint64_t kMaxPolicyBytes = uint64_t{1} << 30;

struct PolicyFile {
  uint64_t layout_hash = 0;     // of the flat parameter vector, see ActingPolicy
  uint32_t policy_version = 0;  // as broadcast; 0 when never broadcast
  uint64_t updates = 0;         // training updates behind it
  Config config;                // of the training, as far as it matters to whoever drives: scenario, seed,
                                // traffic, task, observation, model, algorithm; the rest is the default
  std::vector<float> parameters;
  std::vector<float> critic;  // as of CriticNetwork::layout: nobody drives with it, `dadrl act` shows its
                              // values; empty where there was none, or in a file of format 1
};

// What is saved, without a copy of the parameters.
struct PolicyToSave {
  uint64_t layout_hash = 0;
  uint32_t policy_version = 0;
  uint64_t updates = 0;
  std::string config_yaml;  // ToYaml
  std::span<const float> parameters;
  std::span<const float> critic = {};  // optional
};

// Atomic and durable; blocks on the disk. kExhausted when the disk is full: an earlier file stays.
Status SavePolicy(const std::filesystem::path& path, const PolicyToSave& policy);

// kNotFound when there is no file, kCorrupt when it is damaged or not a policy, kInvalidArgument when another
// version of the program wrote it. Parameters and critics are finite. Blocks on the disk.
Result<PolicyFile> LoadPolicy(const std::filesystem::path& path);

// Whether `policy` fits networks with these parameters (of an ActingPolicy made from policy.config);
// kInvalidArgument that names `path` otherwise.
Status CheckLayout(const PolicyFile& policy, const std::filesystem::path& path, uint64_t layout_hash,
                   size_t parameter_count);

}  // namespace dadrl
