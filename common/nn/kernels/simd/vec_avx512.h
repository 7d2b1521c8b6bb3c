// Sixteen floats in one register: the whole group.
#pragma once

#include <immintrin.h>
#include <stdint.h>

#include "common/nn/kernels/simd/unroll.h"

namespace dadrl::nn::avx512 {

// The kernels are templates over such a type; every function that they generate carries its name, so that no
// two instruction sets share one.
struct Simd {
  using Float = __m512;
  static constexpr int kFloats = 16;

  static DADRL_INLINE Float Zero() { return _mm512_setzero_ps(); }
  static DADRL_INLINE Float Load(const float* p) { return _mm512_load_ps(p); }
  static DADRL_INLINE Float LoadUnaligned(const float* p) { return _mm512_loadu_ps(p); }
  static DADRL_INLINE void Store(float* p, Float a) { _mm512_store_ps(p, a); }
  static DADRL_INLINE void StoreUnaligned(float* p, Float a) { _mm512_storeu_ps(p, a); }
  static DADRL_INLINE Float Broadcast(const float* p) { return _mm512_set1_ps(*p); }
  static DADRL_INLINE Float Add(Float a, Float b) { return _mm512_add_ps(a, b); }
  // a * b + c
  static DADRL_INLINE Float Fma(Float a, Float b, Float c) { return _mm512_fmadd_ps(a, b, c); }
  // max(a, 0); the order of the operands keeps a NaN.
  static DADRL_INLINE Float Relu(Float a) { return _mm512_max_ps(_mm512_setzero_ps(), a); }
  // gradient where output is positive (or NaN), else zero.
  static DADRL_INLINE Float ReluGradient(Float output, Float gradient) {
    return _mm512_maskz_mov_ps(_mm512_cmp_ps_mask(output, _mm512_setzero_ps(), _CMP_NLE_UQ), gradient);
  }
  static DADRL_INLINE float Sum(Float a) {
    const __m256 b = _mm256_add_ps(_mm512_castps512_ps256(a), _mm512_extractf32x8_ps(a, 1));
    const __m128 c = _mm_add_ps(_mm256_castps256_ps128(b), _mm256_extractf128_ps(b, 1));
    const __m128 d = _mm_add_ps(c, _mm_movehl_ps(c, c));
    return _mm_cvtss_f32(_mm_add_ss(d, _mm_shuffle_ps(d, d, 1)));
  }
};

}  // namespace dadrl::nn::avx512
