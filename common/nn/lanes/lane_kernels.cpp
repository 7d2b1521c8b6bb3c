#include "common/nn/lanes/lane_kernels.h"

namespace dadrl::nn {

extern const LaneKernels kLaneKernelsScalar;
extern const LaneKernels kLaneKernelsAvx2;
extern const LaneKernels kLaneKernelsAvx512;

const LaneKernels& LaneKernelsFor(Isa isa) {
#if defined(__x86_64__)
  if (isa == Isa::kAvx512) return kLaneKernelsAvx512;
  if (isa == Isa::kAvx2) return kLaneKernelsAvx2;
#endif
  (void)isa;
  return kLaneKernelsScalar;
}

}  // namespace dadrl::nn
