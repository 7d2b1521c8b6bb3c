// The exported form of experience: a row a frame, in the order it was stored; docs/replay.md.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/step/step_spec.h"

namespace dadrl {

// 1 and 2, which import reads too, have one kind of columns, and no array of successes.
constexpr int kArrayFormat = 3;
constexpr std::string_view kArrayIndex = "index.json";

struct ArrayLayout {
  std::string name;  // of the file, without .npy
  std::string type;  // NumPy's
  std::vector<size_t> row;
  size_t row_bytes = 0;
};

// What every step has (kStepNames). Their arrays stand in this order behind those of the columns.
enum class StepArray {
  kRewards,
  kTerminated,
  kTruncated,
  kHasDecision,
  kPolicyVersion,
  kActor,
  kIncarnation,
  kEpisode,
  kStep,
  kSuccess,
};

// That it does not have in exports of `format`: it is zero there.
inline bool IsIn(StepArray array, uint64_t format) { return array != StepArray::kSuccess || format >= 3; }

// An array a column: those of the observation, those of the decision; then one for each StepArray. Bits are a
// byte each.
std::vector<ArrayLayout> ArrayLayouts(const StepSpec& spec);

// Where an array stands among ArrayLayouts.
inline size_t IndexOf(const StepSpec& spec, StepArray array) {
  return spec.observation.size() + spec.decision.size() + static_cast<size_t>(array);
}

}  // namespace dadrl
