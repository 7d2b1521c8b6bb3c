// A policy on disk, complete in itself: networks by name and the configuration that gives them meaning. What
// `dadrl evaluate --policy` reads.
//
// File, little endian: "DADRLPOL" | u32 format, 3 | u32 policy version | u64 updates | u32 length,
// configuration as YAML | u32 networks | per network: u32 length, name, u64 layout hash, u64 count,
// float32[count] | xxh3-64 of everything before. Formats 1 and 2 are read as well: the policy's layout hash
// stands before the configuration, and behind it, without names, policy and (not in format 1) critics, which
// may be empty.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/config.h"
#include "common/model/named_network.h"
#include "common/util/result.h"

namespace dadrl {

// No policy is longer: three times the largest networks that a configuration allows.
constexpr uint64_t kMaxPolicyBytes = uint64_t{1} << 30;

// A network as a file holds it.
struct StoredNetwork {
  std::string name;
  uint64_t layout_hash = 0;  // 0 where the file does not say: the critics of format 2
  std::vector<float> parameters;

  NamedNetwork view() const { return {name, layout_hash, parameters}; }
};

struct PolicyFile {
  uint32_t policy_version = 0;  // as broadcast; 0 when never broadcast
  uint64_t updates = 0;         // training updates behind it
  Config config;                // of the training, as far as it matters to whoever drives: scenario, seed,
                                // traffic, task, observation, model, algorithm; the rest is the default
  std::vector<StoredNetwork> networks;  // each name once, kPolicyNetwork first; nobody drives with the
                                        // others: `dadrl act` shows what they say, `dadrl export` writes them

  const StoredNetwork& policy() const { return networks.front(); }
  // Null when there is none of that name.
  const StoredNetwork* Find(std::string_view name) const;
};

// What is saved, without a copy of the parameters.
struct PolicyToSave {
  uint32_t policy_version = 0;
  uint64_t updates = 0;
  std::string config_yaml;             // ToYaml
  std::vector<NamedNetwork> networks;  // each name once, kPolicyNetwork first
};

// Atomic and durable; blocks on the disk. kExhausted when the disk is full: an earlier file stays.
Status SavePolicy(const std::filesystem::path& path, const PolicyToSave& policy);

// kNotFound when there is no file, kCorrupt when it is damaged or not a policy, kInvalidArgument when another
// version of the program wrote it. Parameters are finite. Memory is taken only for what a policy's file
// holds. Blocks on the disk.
Result<PolicyFile> LoadPolicy(const std::filesystem::path& path);

// Whether the file at `path` holds `network` with this layout, which the program gives a network of that name
// in the file's configuration; kInvalidArgument that names both otherwise.
Status CheckLayout(const StoredNetwork& network, const std::filesystem::path& path, uint64_t layout_hash,
                   size_t parameter_count);

}  // namespace dadrl
