// The driving columns of an observation by name, for tests that look into them.
#pragma once

#include <cstdint>
#include <span>

#include "common/step/driving_shape.h"
#include "common/step/observation.h"

namespace dadrl {

inline std::span<float> VehiclesOf(Columns& columns) {
  return columns.floats(DrivingShape{}.vehicles_column);
}
inline std::span<const float> VehiclesOf(const Columns& columns) {
  return columns.floats(DrivingShape{}.vehicles_column);
}
inline std::span<float> EgoOf(Columns& columns) { return columns.floats(DrivingShape{}.ego_column); }
inline std::span<const float> EgoOf(const Columns& columns) {
  return columns.floats(DrivingShape{}.ego_column);
}
inline std::span<uint8_t> ContextOf(Columns& columns) { return columns.bits(DrivingShape{}.context_column); }
inline std::span<const uint8_t> ContextOf(const Columns& columns) {
  return columns.bits(DrivingShape{}.context_column);
}

}  // namespace dadrl
