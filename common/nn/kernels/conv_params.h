// The tensors of the convolution stack. Included by the kernel translation units: see conv_shapes.h.
#pragma once

#include "common/nn/kernels/conv_shapes.h"
#include "common/nn/kernels/lane_count.h"

namespace dadrl::nn {

// Tensors in PyTorch's layout, [out][in][row][column] and [out]; lent for the duration of the call.
struct ConvStackParams {
  const float* weight[kConvLayers];
  const float* bias[kConvLayers];
};

// The same shapes; a backward pass overwrites them.
struct ConvStackGrads {
  float* weight[kConvLayers];
  float* bias[kConvLayers];
};

}  // namespace dadrl::nn
