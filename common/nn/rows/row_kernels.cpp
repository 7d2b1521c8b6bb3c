#include "common/nn/rows/row_kernels.h"

namespace dadrl::nn {

extern const RowKernels kRowKernelsScalar;
extern const RowKernels kRowKernelsAvx2;
extern const RowKernels kRowKernelsAvx512;

const RowKernels& RowKernelsFor(Isa isa) {
  return DADRL_FOR_ISA(isa, kRowKernelsScalar, kRowKernelsAvx2, kRowKernelsAvx512);
}

}  // namespace dadrl::nn
