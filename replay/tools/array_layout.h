// The exported form of experience: a row a frame, in the order it was stored; docs/replay.md.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/model/observation.h"

namespace dadrl {

constexpr int kArrayFormat = 1;
constexpr std::string_view kArrayIndex = "index.json";

struct ArrayLayout {
  std::string name;  // of the file, without .npy
  std::string type;  // NumPy's
  std::vector<size_t> row;
  size_t row_bytes = 0;
};

// In this order everywhere.
enum class Column {
  kVehicles,
  kEgo,
  kContext,
  kActions,
  kRewards,
  kTerminated,
  kTruncated,
  kHasAction,
  kPolicyVersion,
  kActor,
  kIncarnation,
  kEpisode,
  kStep,
  kCount
};
constexpr size_t kColumns = static_cast<size_t>(Column::kCount);

inline std::array<ArrayLayout, kColumns> ArrayLayouts(const ObservationSpec& spec) {
  const auto vehicles = static_cast<size_t>(spec.vehicles);
  const auto history = static_cast<size_t>(spec.history);
  constexpr auto kPixels = static_cast<size_t>(ObservationSpec::kContextSize);
  std::array<ArrayLayout, kColumns> layouts{{
      {"vehicles", "<f4", {vehicles, history, ObservationSpec::kVehicleFeatures}},
      {"ego", "<f4", {history, ObservationSpec::kEgoFeatures}},
      {"context", "|u1", {ObservationSpec::kContextPlanes, kPixels, kPixels}},
      {"actions", "<f4", {kActionSize}},
      {"rewards", "<f4", {}},
      {"terminated", "|u1", {}},
      {"truncated", "|u1", {}},
      {"has_action", "|u1", {}},
      {"policy_version", "<u4", {}},
      {"actor", "<u4", {}},
      {"incarnation", "<u8", {}},
      {"episode", "<u8", {}},
      {"step", "<u4", {}},
  }};
  for (ArrayLayout& layout : layouts) {
    layout.row_bytes = static_cast<size_t>(layout.type.back() - '0');
    for (const size_t size : layout.row) layout.row_bytes *= size;
  }
  return layouts;
}

}  // namespace dadrl
