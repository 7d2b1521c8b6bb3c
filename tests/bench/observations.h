// Observations as the road gives them, for benchmarks.
#pragma once

#include <cmath>

#include "common/step/trajectory_batch.h"
#include "common/util/random.h"
#include "tests/driving_columns.h"

namespace dadrl::bench {

// `present` of the vehicles are there with a whole history; a road with a crossing, and a route along it.
inline void FillRoad(const DrivingShape& spec, Random& random, int present, float* vehicles, float* ego,
                     uint8_t* context) {
  for (int i = 0; i < spec.ego_floats(); ++i) ego[i] = static_cast<float>(random.Uniform(-1, 1));
  for (int i = 0; i < spec.vehicle_floats(); ++i) {
    const bool there = i / (spec.history * DrivingShape::kVehicleFeatures) < present;
    const bool flag = i % DrivingShape::kVehicleFeatures == 0;
    vehicles[i] = flag ? (there ? 0.0f : 1.0f) : (there ? static_cast<float>(random.Uniform(-1, 1)) : 0.0f);
  }
  constexpr int kSize = DrivingShape::kContextSize;
  const double slope = random.Uniform(-0.3, 0.3);
  const double column = random.Uniform(54, 74);
  const double row = random.Uniform(10, 70);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const double across = x - column - slope * (y - row);
      const bool planes[] = {std::abs(across) < 18 || std::abs(y - row) < 18, std::abs(across) < 3 && y < 64};
      for (int p = 0; p < DrivingShape::kContextPlanes; ++p) {
        if (planes[p]) context[((p * kSize + y) * kSize + x) / 8] |= static_cast<uint8_t>(1u << (x % 8));
      }
    }
  }
}

// One-step trajectories, one in twenty terminated.
inline TrajectoryBatch RoadBatch(const DrivingShape& spec, int size) {
  TrajectoryBatch batch(spec, {.count = size});
  Random random(1);
  Columns& rows = batch.observations;
  for (int i = 0; i < rows.rows(); ++i) {
    FillRoad(spec, random, static_cast<int>(random.Below(static_cast<uint64_t>(spec.vehicles) + 1)),
             VehiclesOf(rows).data() + static_cast<ptrdiff_t>(i) * spec.vehicle_floats(),
             EgoOf(rows).data() + static_cast<ptrdiff_t>(i) * spec.ego_floats(),
             ContextOf(rows).data() + static_cast<ptrdiff_t>(i) * DrivingShape::kContextBytes);
  }
  for (float& a : batch.decisions[0]) a = static_cast<float>(random.Uniform(-1, 1));
  for (float& r : batch.rewards) r = static_cast<float>(random.Uniform(-1, 1));
  for (uint8_t& end : batch.terminated) end = random.Below(20) == 0 ? 1 : 0;
  std::ranges::fill(batch.steps, 1);
  return batch;
}

}  // namespace dadrl::bench
