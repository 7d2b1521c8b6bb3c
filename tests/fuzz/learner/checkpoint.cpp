// Checkpoints: what is taken is no longer than its file, and a training can have come to it.
#include "learner/checkpoint.h"

#include <cmath>

#include "common/io/read_file.h"
#include "learner/version_reserve.h"
#include "tests/fuzz/outside_text.h"

namespace dadrl::fuzz {
namespace {

Checkpoint Whole() {
  Checkpoint checkpoint;
  checkpoint.updates = 100;
  checkpoint.weights_version = 7;
  checkpoint.trained_s = 12.5;
  checkpoint.cpu_s = 10.5;
  checkpoint.config_yaml = "seed: 1\n";
  checkpoint.published_ns = {1, 2, 3};
  checkpoint.networks = {{"policy", 7, std::vector<float>(5, 0.5f)}};
  checkpoint.blocks = {{"policy", Bytes(20)}, {"critic", Bytes(8)}};
  return checkpoint;
}

Bytes FileOf(const Checkpoint& checkpoint) {
  const auto path = Folder() / "seed";
  Require(SaveCheckpoint(path, checkpoint).has_value());
  return AskMended(ReadFile(path, 1 << 20).value());
}

}  // namespace

const int kMutants = 20000;

bool Check(std::span<std::byte> input) {
  const std::span<const std::byte> bytes = MendedIfAsked(input);
  const auto checkpoint = LoadCheckpoint(Written("checkpoint", bytes));
  if (!Accepted(checkpoint)) return false;
  size_t total = 0;
  for (const Checkpoint::Block& block : checkpoint->blocks) total += block.name.size() + block.bytes.size();
  Require(total <= bytes.size());
  Require(std::isfinite(checkpoint->trained_s) && checkpoint->trained_s >= 0.0);
  Require(std::isfinite(checkpoint->cpu_s) && checkpoint->cpu_s >= 0.0);
  Require(checkpoint->weights_version <= kMaxWeightsVersion);
  Require(checkpoint->updates + 1 > checkpoint->updates);
  for (const int64_t ns : checkpoint->published_ns) Require(ns >= 0);
  for (const float value : checkpoint->networks.front().parameters) Require(std::isfinite(value));
  return true;
}

Seeds MakeSeeds() {
  Checkpoint bare;
  bare.networks.emplace_back();
  Seeds seeds{.accepted = {FileOf(Whole()), FileOf(bare)}, .refused = {AsBytes("DADRLCKP")}};
  Checkpoint endless = Whole();
  endless.trained_s = INFINITY;
  Checkpoint negative = Whole();
  negative.cpu_s = -1.0;
  Checkpoint late = Whole();
  late.weights_version = UINT32_MAX;
  Checkpoint spoilt = Whole();
  spoilt.networks.front().parameters[2] = NAN;
  Checkpoint before_1970 = Whole();
  before_1970.published_ns = {INT64_MIN, INT64_MAX};
  Checkpoint countless = Whole();
  countless.updates = UINT64_MAX;
  for (const Checkpoint& checkpoint : {endless, negative, late, spoilt, before_1970, countless})
    seeds.refused.push_back(FileOf(checkpoint));
  for (const size_t length : {size_t{9}, seeds.accepted[0].size() / 2, seeds.accepted[0].size() - 1}) {
    const auto end = seeds.accepted[0].begin() + static_cast<ptrdiff_t>(length);
    seeds.refused.emplace_back(seeds.accepted[0].begin(), end);
  }
  return seeds;
}

}  // namespace dadrl::fuzz
