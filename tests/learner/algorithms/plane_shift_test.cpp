#include "learner/algorithms/plane_shift.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

#include "common/step/driving_shape.h"
#include "common/util/random.h"

namespace dadrl {
namespace {

constexpr int kSide = DrivingShape::kContextSize;

size_t PixelOf(int plane, int row, int column) {
  return static_cast<size_t>((plane * kSide + row) * kSide + column);
}

bool IsSet(const std::vector<uint8_t>& planes, int plane, int row, int column) {
  const size_t pixel = PixelOf(plane, row, column);
  return (planes[pixel / 8] >> (pixel % 8) & 1) != 0;
}

std::vector<uint8_t> AnyPlanes() {
  Random random(5);
  std::vector<uint8_t> planes(DrivingShape::kContextBytes);
  for (uint8_t& byte : planes) byte = static_cast<uint8_t>(random.Uniform() * 256.0);
  return planes;
}

// Pixel by pixel, as it is meant.
void ExpectShifted(const std::vector<uint8_t>& planes, PlaneShift shift) {
  std::vector<uint8_t> out(planes.size());
  ShiftPlanes(planes, shift, out.data());
  for (int plane = 0; plane < DrivingShape::kContextPlanes; ++plane) {
    for (int row = 0; row < kSide; ++row) {
      for (int column = 0; column < kSide; ++column) {
        const int from_row = std::clamp(row - shift.rows, 0, kSide - 1);
        const int from_column = std::clamp(column - shift.columns, 0, kSide - 1);
        ASSERT_EQ(IsSet(out, plane, row, column), IsSet(planes, plane, from_row, from_column))
            << shift.rows << " down, " << shift.columns << " right, at " << row << ", " << column;
      }
    }
  }
}

TEST(PlaneShift, MovesEveryPixelAndRepeatsTheBorder) {
  const std::vector<uint8_t> planes = AnyPlanes();
  for (const int rows : {-kMaxShiftPixels, -1, 0, 2, kMaxShiftPixels}) {
    for (const int columns : {-kMaxShiftPixels, -3, 0, 1, kMaxShiftPixels}) {
      ExpectShifted(planes, {rows, columns});
    }
  }
}

TEST(PlaneShift, IsUniformInBothDirections) {
  Random random(1);
  constexpr int kDraws = 50000;
  constexpr int kPixels = 2;
  std::map<int, int> rows, columns;
  for (int i = 0; i < kDraws; ++i) {
    const PlaneShift shift =
        ShiftOf(static_cast<float>(random.Normal()), static_cast<float>(random.Normal()), kPixels);
    ++rows[shift.rows];
    ++columns[shift.columns];
  }
  for (const auto& counts : {rows, columns}) {
    ASSERT_EQ(counts.size(), 2u * kPixels + 1);
    for (const auto& [shift, count] : counts) EXPECT_NEAR(count, kDraws / 5, 450) << shift;  // 5 s.d.
  }
}

TEST(PlaneShift, DrawsBeyondEveryBoundStayWithinIt) {
  EXPECT_EQ(ShiftOf(50.0f, -50.0f, 4).rows, 4);
  EXPECT_EQ(ShiftOf(50.0f, -50.0f, 4).columns, -4);
  EXPECT_EQ(ShiftOf(3.0f, -3.0f, 0).rows, 0);
}

}  // namespace
}  // namespace dadrl
