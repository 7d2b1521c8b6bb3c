// The peer of the lane kernels' dense product.
#pragma once

namespace dadrl::bench {

// output [batch x outputs] = input [batch x inputs] * weight [inputs x outputs], column-major, by Eigen
// compiled for AVX-512: the batch-contiguous form of a dense layer.
void EigenProduct(const float* input, const float* weight, float* output, int batch, int inputs, int outputs);

}  // namespace dadrl::bench
