// The exported form of experience: a row a frame, in the order it was stored; docs/replay.md.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/step/step_spec.h"

namespace dadrl {

constexpr int kArrayFormat = 2;  // 1, which import reads too, has one kind of columns
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
};

// An array a column: those of the observation, those of the decision; then one for each StepArray. Bits are a
// byte each.
std::vector<ArrayLayout> ArrayLayouts(const StepSpec& spec);

// Where an array stands among ArrayLayouts.
inline size_t IndexOf(const StepSpec& spec, StepArray array) {
  return spec.observation.size() + spec.decision.size() + static_cast<size_t>(array);
}

}  // namespace dadrl
