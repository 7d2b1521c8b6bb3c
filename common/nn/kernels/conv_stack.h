// The convolutions of the context encoder: two 128x128 bit planes to 256 features, forward and backward.
//
//   conv 2->4 k5, 4->8 k5, 8->16 k5, 16->32 k5, 32->64 k3; stride 2, no padding, ReLU after each; flattened
//   as PyTorch does (channel, row, column). Source: paper, section IV.
//
// The batched functions keep 16 images side by side in each vector, so that every pass is a broadcast weight
// times a vector, without padding channels or rearranging pixels. Threads divide a batch in multiples of 16
// images and call these functions with memory of their own; there is no shared state besides the choice of
// instruction set (isa.h). Nothing here allocates memory except SingleImageConvStack's constructor, and
// nothing blocks. NaN and infinity spread as IEEE arithmetic has it: a NaN weight surfaces in the features; a
// NaN in d_features surfaces in the gradients unless its feature is inactive (zero), as in PyTorch.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "common/nn/kernels/conv_params.h"
#include "common/util/isa.h"

namespace dadrl::nn {

// Number of weights of layer 0..4, and of its biases.
size_t ConvStackWeightCount(int layer);
size_t ConvStackBiasCount(int layer);

// Bytes of working memory for a batch (a multiple of 16): the caller provides it, aligned to 64 bytes and
// uninitialised. for_backward keeps every layer's output of the whole batch; without it the size does not
// depend on the batch.
size_t ConvStackActivationBytes(int batch, bool for_backward);

// context: [batch, 4096] bytes, the first bit of a byte is its lowest. features: [batch / 16, 256, 16], as
// the dense layers take them, overwritten. With keep_for_backward, activations (of
// ConvStackActivationBytes(batch, true)) hold what the backward pass of the same batch and parameters needs,
// until the next call that is given this memory.
void ConvStackForward(const uint8_t* context, int batch, const ConvStackParams& params, void* activations,
                      float* features, bool keep_for_backward);

// Gradients of sum(d_features * features) over the batch; none with respect to the image.
// d_features: [batch / 16, 256, 16]. May be called again on the same activations.
void ConvStackBackward(const uint8_t* context, int batch, const ConvStackParams& params, void* activations,
                       const float* d_features, const ConvStackGrads& grads);

// The acting path: one image, lowest latency. Agrees with the batched path to 1e-5. Owns a packed copy of the
// weights and its scratch memory: one object a thread. Forward uses the instruction set of the last Pack.
class SingleImageConvStack {
 public:
  SingleImageConvStack();
  ~SingleImageConvStack();
  SingleImageConvStack(SingleImageConvStack&&) noexcept;
  SingleImageConvStack& operator=(SingleImageConvStack&&) noexcept;

  // Copies the weights; call again whenever they change. Before the first call all weights are zero.
  void Pack(const ConvStackParams& params);

  // context: [4096] bytes; features: [256], overwritten.
  void Forward(const uint8_t* context, float* features);

 private:
  struct Memory;
  std::unique_ptr<Memory> memory_;
  Isa isa_;
};

}  // namespace dadrl::nn
