// The speed of light of one core: single-precision multiply-adds from registers.
#pragma once

#include <algorithm>
#include <chrono>
#include <vector>

#include "common/util/isa.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace dadrl::bench {

inline double Seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

inline double Quantile(std::vector<double> values, double fraction) {
  const auto at = static_cast<size_t>(fraction * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + static_cast<ptrdiff_t>(at), values.end());
  return values[at];
}

#if defined(__x86_64__)
// Two pipes of latency four need eight chains; sixteen leave no doubt. The barrier keeps the loop from being
// folded.
__attribute__((target("avx512f"))) inline double SpinAvx512(int steps) {
  __m512 sum[16], factor = _mm512_set1_ps(0.5f);
  for (auto& s : sum) s = factor;
  for (int i = 0; i < steps; ++i) {
    asm volatile("" : "+v"(factor));
    for (auto& s : sum) s = _mm512_fmadd_ps(s, factor, factor);
  }
  for (auto& s : sum) asm volatile("" : "+v"(s));
  return 2.0 * 16 * 16 * steps;
}

__attribute__((target("avx2,fma"))) inline double SpinAvx2(int steps) {
  __m256 sum[12], factor = _mm256_set1_ps(0.5f);
  for (auto& s : sum) s = factor;
  for (int i = 0; i < steps; ++i) {
    asm volatile("" : "+x"(factor));
    for (auto& s : sum) s = _mm256_fmadd_ps(s, factor, factor);
  }
  for (auto& s : sum) asm volatile("" : "+x"(s));
  return 2.0 * 12 * 8 * steps;
}
#endif

// Best of a few short runs, in GFLOP/s, with the instruction set in use; 0 where there is no such loop.
inline double CorePeakGflops() {
  double best = 0.0;
#if defined(__x86_64__)
  if (ActiveIsa() == Isa::kScalar) return 0.0;
  for (int i = 0; i < 10; ++i) {
    const double start = Seconds();
    const double flops = ActiveIsa() == Isa::kAvx512 ? SpinAvx512(100000) : SpinAvx2(100000);
    best = std::max(best, flops / (Seconds() - start) * 1e-9);
  }
#endif
  return best;
}

}  // namespace dadrl::bench
