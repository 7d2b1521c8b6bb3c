// Observations as the batched networks read them: sixteen samples in the vector lanes.
#pragma once

#include <cstdint>

#include "common/model/observation.h"
#include "common/nn/aligned_buffer.h"
#include "common/nn/linear.h"

namespace dadrl {

// Some blocks of a batch, rearranged once and read by every encoder. Memory is the arena's; `context` is
// borrowed from the batch. Samples beyond the batch's size are zero.
struct LaneObservations {
  LaneObservations() = default;
  LaneObservations(nn::Arena& arena, const ObservationSpec& spec, int blocks);

  // Takes samples [16 first_block, 16 (first_block + blocks)) of `batch`. `context` holds those samples'
  // planes, whole blocks of them.
  void Pack(const nn::LaneKernels& kernels, const ObservationBatch& batch, const uint8_t* context,
            int first_block);

  // [blocks][20][16], the newest row of `ego`.
  nn::LaneSpan ego_now() const;

  ObservationSpec spec;
  int blocks = 0;
  float* ego = nullptr;  // [blocks][history][20][16]
  float* sequences =
      nullptr;  // [blocks][1 + vehicles][history][7][16]: the ego's first seven features, then vehicles
  nn::LaneSpan absent;                      // [blocks][vehicles][16], 1 where the newest row is absent
  const uint8_t* context_planes = nullptr;  // [16 blocks, 4096] bytes
};

// Floats before `vehicles` in `ego` and in one block of `sequences`.
inline ptrdiff_t EgoBlock(const ObservationSpec& spec) { return ptrdiff_t{spec.ego_floats()} * nn::kLanes; }
inline ptrdiff_t SequenceFloats(const ObservationSpec& spec) {
  return ptrdiff_t{spec.history} * ObservationSpec::kVehicleFeatures * nn::kLanes;
}

}  // namespace dadrl
