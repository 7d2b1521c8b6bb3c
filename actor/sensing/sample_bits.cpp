#include "actor/sensing/sample_bits.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace dadrl {
namespace {

#if defined(__x86_64__)
// Eight points at a time: one gather, then the wanted bit of each word is moved to its sign.
__attribute__((target("avx2"))) void SampleBitsAvx2(const BitGrid& grid, const GridLine& line,
                                                    std::span<uint8_t> out) {
  const auto* words = reinterpret_cast<const int*>(grid.words().data());
  const __m256i stride = _mm256_set1_epi32(grid.stride_words());
  const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  const __m256i highest_bit = _mm256_set1_epi32(31);
  __m256i x =
      _mm256_add_epi32(_mm256_set1_epi32(line.x), _mm256_mullo_epi32(lane, _mm256_set1_epi32(line.step_x)));
  __m256i y =
      _mm256_add_epi32(_mm256_set1_epi32(line.y), _mm256_mullo_epi32(lane, _mm256_set1_epi32(line.step_y)));
  const __m256i step_x = _mm256_set1_epi32(8 * line.step_x);
  const __m256i step_y = _mm256_set1_epi32(8 * line.step_y);
  for (uint8_t& byte : out) {
    const __m256i column = _mm256_srli_epi32(x, 16);
    const __m256i row = _mm256_srli_epi32(y, 16);
    const __m256i index = _mm256_add_epi32(_mm256_mullo_epi32(row, stride), _mm256_srli_epi32(column, 5));
    const __m256i word = _mm256_i32gather_epi32(words, index, 4);
    // 31 - column % 32
    const __m256i shift = _mm256_andnot_si256(column, highest_bit);
    byte = static_cast<uint8_t>(_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_sllv_epi32(word, shift))));
    x = _mm256_add_epi32(x, step_x);
    y = _mm256_add_epi32(y, step_y);
  }
}
#endif

}  // namespace

void SampleBitsScalar(const BitGrid& grid, const GridLine& line, std::span<uint8_t> out) {
  const uint32_t* words = grid.words().data();
  const auto stride = static_cast<uint32_t>(grid.stride_words());
  auto x = static_cast<uint32_t>(line.x);
  auto y = static_cast<uint32_t>(line.y);
  for (uint8_t& byte : out) {
    uint32_t bits = 0;
    for (unsigned i = 0; i < 8; ++i) {
      const uint32_t column = x >> 16U;
      bits |= (words[(y >> 16U) * stride + column / 32] >> (column % 32) & 1U) << i;
      x += static_cast<uint32_t>(line.step_x);
      y += static_cast<uint32_t>(line.step_y);
    }
    byte = static_cast<uint8_t>(bits);
  }
}

void SampleBits(const BitGrid& grid, const GridLine& line, std::span<uint8_t> out) {
#if defined(__x86_64__)
  static const bool kHasAvx2 = __builtin_cpu_supports("avx2") != 0;
  if (kHasAvx2) {
    SampleBitsAvx2(grid, line, out);
    return;
  }
#endif
  SampleBitsScalar(grid, line, out);
}

}  // namespace dadrl
