#include "common/model/lane_observations.h"

#include <algorithm>
#include <cstring>

namespace dadrl {

using nn::kLanes;

LaneObservations::LaneObservations(nn::Arena& arena, const DrivingShape& observation_spec, int block_count)
    : spec(observation_spec), blocks(block_count) {
  const auto count = static_cast<size_t>(blocks);
  ego = arena.Allocate(count * static_cast<size_t>(EgoBlock(spec)));
  sequences = arena.Allocate(count * static_cast<size_t>((1 + spec.vehicles) * SequenceFloats(spec)));
  absent = nn::Contiguous(arena.Allocate(count * static_cast<size_t>(spec.vehicles) * kLanes), spec.vehicles);
}

nn::LaneSpan LaneObservations::ego_now() const {
  return nn::LaneSpan{ego, EgoBlock(spec)}.From((spec.history - 1) * DrivingShape::kEgoFeatures);
}

void LaneObservations::Pack(const nn::LaneKernels& kernels, ColumnRows batch, const uint8_t* context,
                            int first_block) {
  context_planes = context;
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
    constexpr size_t kRow = size_t{DrivingShape::kVehicleFeatures} * kLanes;
    for (int t = 0; t < spec.history; ++t) {
      std::memcpy(block + static_cast<size_t>(t) * kRow,
                  block_ego + ptrdiff_t{t} * DrivingShape::kEgoFeatures * kLanes, kRow * sizeof(float));
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
