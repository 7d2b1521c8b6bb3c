// The polylines of make_scene_golden.py.
#pragma once

#include "common/step/driving_shape.h"
#include "tests/golden/golden.h"

namespace dadrl {

// Those of observation batch `index`.
inline void FillWays(const DrivingShape& shape, int index, Columns& batch) {
  const std::span<float> ways = batch.floats(shape.polylines_column);
  std::ranges::copy(golden::Uniform(130 + static_cast<uint64_t>(index), ways.size()), ways.begin());
  constexpr size_t kFeatures = DrivingShape::kPointFeatures;
  constexpr int kPoints = DrivingShape::kWayPoints;
  for (size_t at = 0; at < ways.size(); at += kFeatures) {
    const int point = static_cast<int>(at / kFeatures);
    const int sample = point / kPoints / shape.ways();
    const int way = point / kPoints % shape.ways();
    const std::span<float> features = ways.subspan(at, kFeatures);
    const bool present = point % kPoints < (sample * 3 + way * 5 + index) % 13;
    if (!present) std::ranges::fill(features, 0.0f);
    features[0] = present ? 0.0f : 1.0f;
  }
}

}  // namespace dadrl
