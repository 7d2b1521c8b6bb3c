// Trajectories on their way from the replay to the learner, observations still compressed.
//
// Wire format, little endian: magic u32, version u32, schema u64, trajectories u32, steps u32, all
// observations u32 (0 or 1), decision floats u32, total bytes u64 | of each trajectory: key u64, probability
// f32, importance weight f32, steps u16, end u16 (0 none, 1 terminated, 2 truncated) | of each step of each:
// policy_version u32, reward f32, decision f32[] | length u32 of each payload | payloads | xxh3-64 of
// everything before. Payloads of a trajectory are those of its steps (or the first alone), and the one behind
// unless it terminated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/step/trajectory_batch.h"
#include "common/util/result.h"
#include "proto/experience_bounds.h"
#include "proto/payload_codec.h"

namespace dadrl {

constexpr int kMaxTrajectorySteps = 256;  // as algorithm.n_step and replay.sequence_length allow

struct SampledStep {
  uint32_t policy_version = 0;
  float reward = 0.0f;
  std::span<const std::byte> decision;
};

// As sampled; borrows what it points to until it is sent.
struct SampledTrajectory {
  uint64_t key = 0;
  float probability = 1.0f;        // of having been sampled
  float importance_weight = 1.0f;  // scaled so that the largest of the batch is 1
  bool terminated = false;         // at its last step; then there is no payload behind it
  bool truncated = false;
  std::span<const SampledStep> steps;  // 1 to kMaxTrajectorySteps
  std::span<const std::span<const std::byte>> payloads;
};

// What EncodeTrajectories makes of them.
size_t TrajectoriesBytes(std::span<const SampledTrajectory> trajectories);

// Serialises trajectories of `shape`. `memory` of an earlier batch is used again.
std::vector<std::byte> EncodeTrajectories(std::span<const SampledTrajectory> trajectories,
                                          const TrajectoryShape& shape, uint64_t schema,
                                          std::vector<std::byte> memory = {});

// Not thread safe. Takes 5 to 10 us an observation: keep it off the training thread.
class TrajectoryDecoder {
 public:
  TrajectoryDecoder(const StepSpec& spec, const ExperienceBounds& bounds);

  // Fills `batch`, whose shape must be the message's. kCorrupt on anything that does not fit, and on numbers
  // beyond the bounds of their columns or of the task (`batch` is then unspecified); never reads outside
  // `bytes`.
  Status Decode(std::span<const std::byte> bytes, TrajectoryBatch& batch);

 private:
  struct Entry;
  struct Sections;

  Result<Sections> CheckEnvelope(std::span<const std::byte> bytes, const TrajectoryBatch& batch) const;
  Status DecodeSteps(Sections& sections, const Entry& entry, size_t index, TrajectoryBatch& batch);
  Status DecodePayloads(Sections& sections, const Entry& entry, size_t index, TrajectoryBatch& batch);

  const StepSpec spec_;
  const uint64_t schema_;
  const ExperienceBounds bounds_;
  PayloadCodec codec_;
  std::vector<float> decision_;
};

}  // namespace dadrl
