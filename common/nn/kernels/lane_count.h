// Included by the kernel translation units: see conv_shapes.h.
#pragma once

namespace dadrl::nn {

// Samples side by side: what lies next to each other in the activations of every layer, convolutions
// included. Batches are multiples of it.
inline constexpr int kLanes = 16;

}  // namespace dadrl::nn
