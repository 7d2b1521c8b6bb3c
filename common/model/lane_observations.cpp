#include "common/model/lane_observations.h"

#include <algorithm>
#include <cstring>

namespace dadrl {

using nn::kLanes;

LaneObservations::LaneObservations(nn::Arena& arena, const DrivingShape& observation_spec, int block_count)
    : spec(observation_spec), blocks(block_count) {
  ego = arena.Allocate(blocks * EgoBlock(spec));
  sequences = arena.Allocate(blocks * (1 + spec.vehicles) * SequenceFloats(spec));
  absent = nn::TakeLanes(arena, spec.vehicles, blocks);
}

nn::LaneSpan LaneObservations::ego_now() const {
  return nn::LaneSpan{ego, EgoBlock(spec)}.From((spec.history - 1) * DrivingShape::kEgoFeatures);
}

void LaneObservations::Pack(const nn::LaneKernels& kernels, ColumnRows batch, const uint8_t* context,
                            int first_block) {
  context_planes = context;
  rows = batch;
  first_row = first_block * kLanes;
  const ptrdiff_t sequence = SequenceFloats(spec);
  const float* const batch_ego = batch.floats(spec.ego_column).data();
  const float* const batch_vehicles = batch.floats(spec.vehicles_column).data();
  for (int b = 0; b < blocks; ++b) {
    const int first = (first_block + b) * kLanes;
    const int count = std::clamp(batch.rows() - first, 0, kLanes);
    float* block_ego = ego + b * EgoBlock(spec);
    kernels.to_lanes(batch_ego + ptrdiff_t{first} * spec.ego_floats(), spec.ego_floats(), count,
                     spec.ego_floats(), block_ego);
    float* block = sequences + b * (1 + spec.vehicles) * sequence;
    constexpr int kRow = DrivingShape::kVehicleFeatures * kLanes;
    for (int t = 0; t < spec.history; ++t) {
      std::copy_n(block_ego + t * DrivingShape::kEgoFeatures * kLanes, kRow, block + t * kRow);
    }
    kernels.to_lanes(batch_vehicles + ptrdiff_t{first} * spec.vehicle_floats(), spec.vehicle_floats(), count,
                     spec.vehicle_floats(), block + sequence);
    for (int v = 0; v < spec.vehicles; ++v) {
      const float* newest = block + (v + 2) * sequence - kRow;
      std::memcpy(absent.block(b) + ptrdiff_t{v} * kLanes, newest, kLanes * sizeof(float));
    }
  }
}

}  // namespace dadrl
