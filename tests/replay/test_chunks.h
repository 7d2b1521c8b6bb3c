// Small chunks whose every frame can be told from every other.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/util/random.h"
#include "proto/experience.h"
#include "proto/experience_bounds.h"
#include "proto/trajectory_codec.h"
#include "tests/common/io/temporary_folder.h"
#include "tests/driving_columns.h"

namespace dadrl {

inline const DrivingShape kTestSpec{.vehicles = 1, .history = 1};
inline const ExperienceBounds kTestBounds = ExperienceBounds::From(Config{});

struct TestChunk {
  ChunkIdentity identity{1, 1, 1};
  uint64_t episode = 1;
  uint32_t first_frame = 0;
  int frames = 4;            // with an action
  uint8_t end = 0;           // kTerminated or kTruncated on the last of them
  bool final_frame = false;  // the observation after a truncation follows (alone when frames is 0)
  uint32_t policy_version = 1;
  std::optional<float> last_reward = std::nullopt;  // in place of the last action's
};

// Makes whole numbers small enough for a reward or a feature; exact.
constexpr float kTestScale = 0x1p-20f;
// What stands in frame `frame` of `episode` of `actor`.
inline float TestReward(uint32_t actor, uint64_t episode, uint32_t frame) {
  return static_cast<float>(actor * 10000 + episode * 100 + frame) * kTestScale;
}
inline Observation TestObservation(uint32_t actor, uint64_t episode, uint32_t frame) {
  Observation observation(kTestSpec);
  EgoOf(observation)[1] = TestReward(actor, episode, frame);
  return observation;
}

inline std::vector<std::byte> Build(const TestChunk& chunk) {
  ChunkBuilder builder(kTestSpec, FloatCoding::kFloat32);
  builder.Begin(chunk.episode, chunk.first_frame);
  uint32_t frame = chunk.first_frame;
  for (int i = 0; i < chunk.frames; ++i, ++frame) {
    const bool last = i + 1 == chunk.frames;
    const float reward = TestReward(chunk.identity.actor, chunk.episode, frame);
    builder.AddTransition(TestObservation(chunk.identity.actor, chunk.episode, frame), Action{0.5f, -0.5f},
                          last ? chunk.last_reward.value_or(reward) : reward, last ? chunk.end : uint8_t{0},
                          chunk.policy_version);
  }
  if (chunk.final_frame) builder.AddFinal(TestObservation(chunk.identity.actor, chunk.episode, frame));
  return builder.Finish(chunk.identity);
}

inline std::vector<float> RewardsOf(const SampledTrajectory& trajectory) {
  std::vector<float> rewards;
  for (const SampledStep& step : trajectory.steps) rewards.push_back(step.reward);
  return rewards;
}

// The TestReward that a payload stands for.
inline float Decode(std::span<const std::byte> payload) {
  PayloadCodec codec(kTestSpec, FloatCoding::kFloat32);
  Observation observation(kTestSpec);
  if (!codec.Decode(payload, observation)) return -1.0f;
  return EgoOf(observation)[1];
}

}  // namespace dadrl
