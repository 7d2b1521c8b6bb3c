#include "learner/algorithms/plane_shift.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/step/driving_shape.h"

namespace dadrl {
namespace {

// A row of a plane; the first pixel is the lowest bit of `low`.
struct Row {
  uint64_t low = 0;
  uint64_t high = 0;
};
constexpr size_t kRowBytes = sizeof(Row);
static_assert(kRowBytes * 8 == kBitPlaneSide);
constexpr int kWordBits = 64;

// As many of the lowest bits as `bits`, which is below kWordBits.
constexpr uint64_t Lowest(int bits) { return (uint64_t{1} << bits) - 1; }

Row Right(Row row, int by) {
  if (by == 0) return row;
  const uint64_t border = (row.low & 1) != 0 ? Lowest(by) : 0;
  return {row.low << by | border, row.high << by | row.low >> (kWordBits - by)};
}

Row Left(Row row, int by) {
  const uint64_t border = row.high >> (kWordBits - 1) != 0 ? Lowest(by) << (kWordBits - by) : 0;
  return {row.low >> by | row.high << (kWordBits - by), row.high >> by | border};
}

int Uniform(float noise, int pixels) {
  const double unit = 0.5 * std::erfc(-static_cast<double>(noise) * M_SQRT1_2);
  const int width = 2 * pixels + 1;
  return std::min(static_cast<int>(unit * width), width - 1) - pixels;
}

}  // namespace

PlaneShift ShiftOf(float row_noise, float column_noise, int pixels) {
  return {Uniform(row_noise, pixels), Uniform(column_noise, pixels)};
}

void ShiftPlanes(std::span<const uint8_t> planes, PlaneShift shift, uint8_t* out) {
  constexpr size_t kPlaneBytes = kRowBytes * kBitPlaneSide;
  for (size_t plane = 0; plane < planes.size(); plane += kPlaneBytes) {
    for (int to = 0; to < kBitPlaneSide; ++to, out += kRowBytes) {
      const auto from = static_cast<size_t>(std::clamp(to - shift.rows, 0, kBitPlaneSide - 1));
      Row row;
      std::memcpy(&row, &planes[plane + from * kRowBytes], kRowBytes);
      row = shift.columns < 0 ? Left(row, -shift.columns) : Right(row, shift.columns);
      std::memcpy(out, &row, kRowBytes);
    }
  }
}

}  // namespace dadrl
