#include "common/nn/kernels/conv_stack.h"

#include <algorithm>
#include <cassert>
#include <iterator>
#include <new>

#include "common/nn/kernels/conv_table.h"

namespace dadrl::nn {
namespace {

constexpr std::align_val_t kCacheLine{64};

const ConvKernelTable& Kernels(Isa isa) {
  return DADRL_FOR_ISA(isa, scalar::kConvKernels, avx2::kConvKernels, avx512::kConvKernels);
}

// The largest over the instruction sets, so that memory sized under one serves under another.
template <class Value>
size_t Largest(Value value) {
  size_t largest = 0;
  for (int isa = 0; isa <= static_cast<int>(DetectIsa()); ++isa) {
    largest = std::max(largest, value(Kernels(static_cast<Isa>(isa))));
  }
  return largest;
}

size_t RoundUp(size_t floats) { return (floats + 15) / 16 * 16; }

size_t ScratchFloats() {
  return RoundUp(Largest([](const ConvKernelTable& k) { return k.scratch_floats; }));
}

[[maybe_unused]] bool IsValidBatch(int batch) { return batch >= 0 && batch % kLanes == 0; }

}  // namespace

size_t ConvStackWeightCount(int layer) {
  assert(layer >= 0 && layer < kConvLayers);
  return static_cast<size_t>(kConvLayerShapes[layer].weights);
}

size_t ConvStackBiasCount(int layer) {
  assert(layer >= 0 && layer < kConvLayers);
  return static_cast<size_t>(kConvLayerShapes[layer].out);
}

size_t ConvStackActivationBytes(int batch, bool for_backward) {
  assert(IsValidBatch(batch));
  const size_t group = RoundUp(Largest([](const ConvKernelTable& k) { return k.floats_per_group; }));
  const size_t groups = for_backward ? static_cast<size_t>(batch / kLanes) : 1;
  return (ScratchFloats() + groups * group) * sizeof(float);
}

void ConvStackForward(const uint8_t* context, int batch, const ConvStackParams& params, void* activations,
                      float* features, bool keep_for_backward) {
  assert(IsValidBatch(batch));
  assert(reinterpret_cast<uintptr_t>(activations) % 64 == 0);
  float* const scratch = static_cast<float*>(activations);
  Kernels(ActiveIsa())
      .forward(context, batch, params, scratch + ScratchFloats(), scratch, features, keep_for_backward);
}

void ConvStackBackward(const uint8_t* context, int batch, const ConvStackParams& params, void* activations,
                       const float* d_features, const ConvStackGrads& grads) {
  assert(IsValidBatch(batch));
  assert(reinterpret_cast<uintptr_t>(activations) % 64 == 0);
  float* const scratch = static_cast<float*>(activations);
  Kernels(ActiveIsa())
      .backward(context, batch, params, scratch + ScratchFloats(), scratch, d_features, grads);
}

struct SingleImageConvStack::Memory {
  Memory()
      : packed(RoundUp(Largest([](const ConvKernelTable& k) { return k.single_packed_floats; }))),
        scratch(RoundUp(Largest([](const ConvKernelTable& k) { return k.single_scratch_floats; }))),
        floats(static_cast<float*>(::operator new((packed + scratch) * sizeof(float), kCacheLine))) {
    std::fill_n(floats, packed + scratch, 0.0F);
  }
  ~Memory() { ::operator delete(floats, kCacheLine); }
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;

  const size_t packed;
  const size_t scratch;
  float* const floats;
};

SingleImageConvStack::SingleImageConvStack() : memory_(std::make_unique<Memory>()), isa_(ActiveIsa()) {}
SingleImageConvStack::~SingleImageConvStack() = default;
SingleImageConvStack::SingleImageConvStack(SingleImageConvStack&&) noexcept = default;
SingleImageConvStack& SingleImageConvStack::operator=(SingleImageConvStack&&) noexcept = default;

void SingleImageConvStack::Pack(const ConvStackParams& params) {
  isa_ = ActiveIsa();
  Kernels(isa_).single_pack(params, memory_->floats);
}

void SingleImageConvStack::Forward(const uint8_t* context, float* features) {
  Kernels(isa_).single_forward(context, memory_->floats, memory_->floats + memory_->packed, features);
}

}  // namespace dadrl::nn
