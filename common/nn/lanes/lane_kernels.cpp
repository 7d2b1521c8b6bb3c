#include "common/nn/lanes/lane_kernels.h"

namespace dadrl::nn {

extern const LaneKernels kLaneKernelsScalar;
extern const LaneKernels kLaneKernelsAvx2;
extern const LaneKernels kLaneKernelsAvx512;

const LaneKernels& LaneKernelsFor(Isa isa) {
  return DADRL_FOR_ISA(isa, kLaneKernelsScalar, kLaneKernelsAvx2, kLaneKernelsAvx512);
}

}  // namespace dadrl::nn
