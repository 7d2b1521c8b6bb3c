// Observations as the batched networks read them: sixteen samples in the vector lanes.
#pragma once

#include <cstdint>
#include <optional>

#include "common/nn/aligned_buffer.h"
#include "common/nn/linear.h"
#include "common/step/driving_shape.h"

namespace dadrl {

// Some blocks of a batch, rearranged once and read by every encoder. Memory is the arena's; `context` is
// borrowed from the batch, and so are `rows`. Samples beyond the batch's size are zero.
struct LaneObservations {
  LaneObservations() = default;
  LaneObservations(nn::Arena& arena, const DrivingShape& spec, int blocks);

  // Takes samples [16 first_block, 16 (first_block + blocks)) of `batch`. `context` holds those samples'
  // planes, whole blocks of them.
  void Pack(const nn::LaneKernels& kernels, ColumnRows batch, const uint8_t* context, int first_block);

  // [blocks][20][16], the newest row of `ego`.
  nn::LaneSpan ego_now() const;

  DrivingShape spec;
  int blocks = 0;
  float* ego = nullptr;  // [blocks][history][20][16]
  float* sequences =
      nullptr;  // [blocks][1 + vehicles][history][7][16]: the ego's first seven features, then vehicles
  nn::LaneSpan absent;                      // [blocks][vehicles][16], 1 where the newest row is absent
  const uint8_t* context_planes = nullptr;  // [16 blocks, 4096] bytes
  std::optional<ColumnRows> rows;           // the whole batch, for what reads it as it is
  int first_row = 0;                        // the first of these samples
};

// Floats before `vehicles` in `ego` and in one block of `sequences`.
inline ptrdiff_t EgoBlock(const DrivingShape& spec) { return ptrdiff_t{spec.ego_floats()} * nn::kLanes; }
inline ptrdiff_t SequenceFloats(const DrivingShape& spec) {
  return ptrdiff_t{spec.history} * DrivingShape::kVehicleFeatures * nn::kLanes;
}

}  // namespace dadrl
