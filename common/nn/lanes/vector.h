// The vector type of the lane kernels and its functions. Only the kernel translation units include this: each
// is compiled for one instruction set, and everything here has internal linkage so that the linker cannot
// merge them.
#pragma once

#include <cstdint>

#include "common/nn/kernels/lane_count.h"

namespace dadrl::nn {
namespace {

#define DADRL_INLINE inline __attribute__((always_inline))

// Sixteen samples. One register with AVX-512, two with AVX2, four with SSE2: the compiler splits it.
typedef float Lanes __attribute__((vector_size(64)));
typedef uint32_t LaneBits __attribute__((vector_size(64)));
static_assert(sizeof(Lanes) == kLanes * sizeof(float));

DADRL_INLINE Lanes Load(const float* from) {
  Lanes value;
  __builtin_memcpy(&value, from, sizeof(value));
  return value;
}

DADRL_INLINE void Store(float* to, const Lanes& value) { __builtin_memcpy(to, &value, sizeof(value)); }

// The first `count` of sixteen, the rest zero.
DADRL_INLINE Lanes LoadPart(const float* from, int count) {
  float all[kLanes] = {};
  for (int i = 0; i < count; ++i) all[i] = from[i];
  return Load(all);
}

DADRL_INLINE void StorePart(float* to, const Lanes& value, int count) {
  for (int i = 0; i < count; ++i) to[i] = value[i];
}

// Subtracting zero, unlike adding it, is the identity for every float, so this is one broadcast.
DADRL_INLINE Lanes Splat(float value) { return value - Lanes{}; }

// Keeps NaN: the comparison is false for it.
DADRL_INLINE Lanes Relu(const Lanes& x) { return x < 0.0f ? Lanes{} : x; }

DADRL_INLINE Lanes Sqrt(const Lanes& x) {
  Lanes root;
  for (int i = 0; i < kLanes; ++i) root[i] = __builtin_sqrtf(x[i]);
  return root;
}

// e^x, relative error below 2e-7 (Cephes expf); saturates at e^-87 and e^88; NaN stays NaN.
DADRL_INLINE Lanes Exp(const Lanes& argument) {
  const Lanes low = Splat(-87.0f);
  const Lanes high = Splat(88.0f);
  Lanes x = argument < low ? low : argument;
  x = x > high ? high : x;
  // Adding 1.5 * 2^23 rounds to an integer and leaves it in the low mantissa bits.
  const Lanes shifted = x * 1.44269504f + 12582912.0f;
  const Lanes n = shifted - 12582912.0f;
  Lanes r = x - n * 0.693359375f;
  r = r + n * 2.12194440e-4f;
  Lanes p = Splat(1.9875691500e-4f);
  p = p * r + 1.3981999507e-3f;
  p = p * r + 8.3334519073e-3f;
  p = p * r + 4.1665795894e-2f;
  p = p * r + 1.6666665459e-1f;
  p = p * r + 5.0000001201e-1f;
  p = p * (r * r) + r + 1.0f;
  return reinterpret_cast<Lanes>(reinterpret_cast<LaneBits>(p) + (reinterpret_cast<LaneBits>(shifted) << 23));
}

DADRL_INLINE Lanes Sigmoid(const Lanes& x) { return 1.0f / (1.0f + Exp(-x)); }

// Absolute error below 2e-7.
DADRL_INLINE Lanes Tanh(const Lanes& x) { return 1.0f - 2.0f / (1.0f + Exp(2.0f * x)); }

// Transposes a 16 x 16 block held in sixteen vectors: four rounds that exchange ever smaller off-diagonal
// blocks.
DADRL_INLINE void Transpose(Lanes (&v)[kLanes]) {
  for (int i = 0; i < kLanes; ++i) {
    if ((i & 8) != 0) continue;
    const Lanes a = v[i];
    const Lanes b = v[i + 8];
    v[i] = __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23);
    v[i + 8] = __builtin_shufflevector(a, b, 8, 9, 10, 11, 12, 13, 14, 15, 24, 25, 26, 27, 28, 29, 30, 31);
  }
  for (int i = 0; i < kLanes; ++i) {
    if ((i & 4) != 0) continue;
    const Lanes a = v[i];
    const Lanes b = v[i + 4];
    v[i] = __builtin_shufflevector(a, b, 0, 1, 2, 3, 16, 17, 18, 19, 8, 9, 10, 11, 24, 25, 26, 27);
    v[i + 4] = __builtin_shufflevector(a, b, 4, 5, 6, 7, 20, 21, 22, 23, 12, 13, 14, 15, 28, 29, 30, 31);
  }
  for (int i = 0; i < kLanes; ++i) {
    if ((i & 2) != 0) continue;
    const Lanes a = v[i];
    const Lanes b = v[i + 2];
    v[i] = __builtin_shufflevector(a, b, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29);
    v[i + 2] = __builtin_shufflevector(a, b, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31);
  }
  for (int i = 0; i < kLanes; ++i) {
    if ((i & 1) != 0) continue;
    const Lanes a = v[i];
    const Lanes b = v[i + 1];
    v[i] = __builtin_shufflevector(a, b, 0, 16, 2, 18, 4, 20, 6, 22, 8, 24, 10, 26, 12, 28, 14, 30);
    v[i + 1] = __builtin_shufflevector(a, b, 1, 17, 3, 19, 5, 21, 7, 23, 9, 25, 11, 27, 13, 29, 15, 31);
  }
}

}  // namespace
}  // namespace dadrl::nn
