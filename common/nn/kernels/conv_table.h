// What one instruction set provides; the dispatcher (conv_stack.cpp) calls through it.
//
// Included by the kernel translation units: see conv_shapes.h for what that forbids.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "common/nn/kernels/conv_params.h"

namespace dadrl::nn {

struct ConvKernelTable {
  // Floats of working memory: for each group of 16 images when its outputs are kept, and once a call.
  size_t floats_per_group;
  size_t scratch_floats;
  void (*forward)(const uint8_t* context, int batch, const ConvStackParams& params, float* groups,
                  float* scratch, float* features, bool keep);
  void (*backward)(const uint8_t* context, int batch, const ConvStackParams& params, const float* groups,
                   float* scratch, const float* d_features, const ConvStackGrads& grads);
  // The single-image path: floats of packed weights and of scratch.
  size_t single_packed_floats;
  size_t single_scratch_floats;
  void (*single_pack)(const ConvStackParams& params, float* packed);
  void (*single_forward)(const uint8_t* context, const float* packed, float* scratch, float* features);
};

namespace scalar {
extern const ConvKernelTable kConvKernels;
}
namespace avx2 {
extern const ConvKernelTable kConvKernels;
}
namespace avx512 {
extern const ConvKernelTable kConvKernels;
}

}  // namespace dadrl::nn
