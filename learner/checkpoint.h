// Everything a resumed training needs, in memory and as one file.
//
// File, little endian: "DADRLCKP" | u32 format | u32 blocks | u64 file length | u64 updates | u32 weights
// version | f64 trained seconds | f64 processor seconds (format 1: not there) | u64 layout hash | u32 length,
// configuration as YAML | u64 count, i64 publish times | u64 count, float32 published policy | per block: u32
// length, name, u64 length | the blocks' bytes | xxh3-64 of everything before.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/model/policy_file.h"
#include "common/util/result.h"
#include "learner/algorithms/algorithm.h"

namespace dadrl {

struct Checkpoint {
  struct Block {
    std::string name;
    std::vector<std::byte> bytes;
  };

  uint64_t updates = 0;
  uint32_t weights_version = 0;         // newest that was broadcast
  double trained_s = 0.0;               // wall time spent training, all processes of the run together
  double cpu_s = 0.0;                   // the learners' processor time in it; 0 from a file of format 1
  std::string config_yaml;              // ToYaml
  std::vector<int64_t> published_ns;    // wall times of the newest versions, the last is weights_version's
  std::vector<StoredNetwork> networks;  // Algorithm::networks; only the first, the policy, of a file
  std::vector<Block> blocks;            // Algorithm::state
};

// Copies the algorithm's state and networks into `checkpoint`, reusing its memory.
void CaptureState(Algorithm& algorithm, Checkpoint& checkpoint);

// Writes the blocks back: the algorithm is then bit for bit what was captured. kCorrupt, and the algorithm
// untouched, when names or lengths differ; `path` names the file in the error.
Status RestoreState(const Checkpoint& checkpoint, const std::filesystem::path& path, Algorithm& algorithm);

// Atomic and durable; blocks on the disk.
Status SaveCheckpoint(const std::filesystem::path& path, const Checkpoint& checkpoint);

// kNotFound without a file, kCorrupt when damaged or not a checkpoint, kInvalidArgument when of another
// format. Memory is taken only for what a checkpoint's file holds.
Result<Checkpoint> LoadCheckpoint(const std::filesystem::path& path);

// Whether a training with `now` may go on from a checkpoint of `saved`: the keys that shape the networks and
// their input must agree. kInvalidArgument with each key that differs and both values.
Status CheckSameNetworks(const Config& saved, const Config& now, const std::filesystem::path& path);

}  // namespace dadrl
