// Eight floats in one register: half of the group.
#pragma once

#include <immintrin.h>
#include <stdint.h>

#include "common/nn/kernels/simd/unroll.h"

namespace dadrl::nn::avx2 {

// See vec_avx512.h.
struct Simd {
  using Float = __m256;
  static constexpr int kFloats = 8;

  static DADRL_INLINE Float Zero() { return _mm256_setzero_ps(); }
  static DADRL_INLINE Float Load(const float* p) { return _mm256_load_ps(p); }
  static DADRL_INLINE Float LoadUnaligned(const float* p) { return _mm256_loadu_ps(p); }
  static DADRL_INLINE void Store(float* p, Float a) { _mm256_store_ps(p, a); }
  static DADRL_INLINE void StoreUnaligned(float* p, Float a) { _mm256_storeu_ps(p, a); }
  static DADRL_INLINE Float Broadcast(const float* p) { return _mm256_broadcast_ss(p); }
  static DADRL_INLINE Float Add(Float a, Float b) { return _mm256_add_ps(a, b); }
  static DADRL_INLINE Float Fma(Float a, Float b, Float c) { return _mm256_fmadd_ps(a, b, c); }
  static DADRL_INLINE Float Relu(Float a) { return _mm256_max_ps(_mm256_setzero_ps(), a); }
  static DADRL_INLINE Float ReluGradient(Float output, Float gradient) {
    return _mm256_and_ps(_mm256_cmp_ps(output, _mm256_setzero_ps(), _CMP_NLE_UQ), gradient);
  }
  static DADRL_INLINE float Sum(Float a) {
    const __m128 c = _mm_add_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1));
    const __m128 d = _mm_add_ps(c, _mm_movehl_ps(c, c));
    return _mm_cvtss_f32(_mm_add_ss(d, _mm_shuffle_ps(d, d, 1)));
  }
};

}  // namespace dadrl::nn::avx2
