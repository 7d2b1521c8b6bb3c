// Observations as the road gives them, for benchmarks.
#pragma once

#include <cmath>

#include "common/model/transition_batch.h"
#include "common/util/random.h"

namespace dadrl::bench {

// `present` of the vehicles are there with a whole history; a road with a crossing, and a route along it.
inline void FillRoad(const ObservationSpec& spec, Random& random, int present, float* vehicles, float* ego,
                     uint8_t* context) {
  for (int i = 0; i < spec.ego_floats(); ++i) ego[i] = static_cast<float>(random.Uniform(-1, 1));
  for (int i = 0; i < spec.vehicle_floats(); ++i) {
    const bool there = i / (spec.history * ObservationSpec::kVehicleFeatures) < present;
    const bool flag = i % ObservationSpec::kVehicleFeatures == 0;
    vehicles[i] = flag ? (there ? 0.0f : 1.0f) : (there ? static_cast<float>(random.Uniform(-1, 1)) : 0.0f);
  }
  constexpr int kSize = ObservationSpec::kContextSize;
  const double slope = random.Uniform(-0.3, 0.3);
  const double column = random.Uniform(54, 74);
  const double row = random.Uniform(10, 70);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const double across = x - column - slope * (y - row);
      const bool planes[] = {std::abs(across) < 18 || std::abs(y - row) < 18, std::abs(across) < 3 && y < 64};
      for (int p = 0; p < ObservationSpec::kContextPlanes; ++p) {
        if (planes[p]) context[((p * kSize + y) * kSize + x) / 8] |= static_cast<uint8_t>(1u << (x % 8));
      }
    }
  }
}

inline TransitionBatch RoadBatch(const ObservationSpec& spec, int size) {
  TransitionBatch batch(spec, size);
  Random random(1);
  for (ObservationBatch* observation : {&batch.observation, &batch.next_observation}) {
    for (int i = 0; i < size; ++i) {
      FillRoad(spec, random, static_cast<int>(random.Below(static_cast<uint64_t>(spec.vehicles) + 1)),
               observation->vehicles.data() + static_cast<ptrdiff_t>(i) * spec.vehicle_floats(),
               observation->ego.data() + static_cast<ptrdiff_t>(i) * spec.ego_floats(),
               observation->context.data() + static_cast<ptrdiff_t>(i) * ObservationSpec::kContextBytes);
    }
  }
  for (float& a : batch.action) a = static_cast<float>(random.Uniform(-1, 1));
  for (float& r : batch.reward) r = static_cast<float>(random.Uniform(-1, 1));
  for (float& d : batch.discount) d = random.Below(20) == 0 ? 0.0f : 0.99f;
  return batch;
}

}  // namespace dadrl::bench
