#include "proto/codec/plane_codec.h"

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <vector>

#include "common/util/random.h"

namespace dadrl {
namespace {

using Plane = std::array<uint8_t, kPlaneBytes>;

Plane Paint(const std::function<bool(int row, int column)>& inside) {
  Plane plane{};
  for (int row = 0; row < 128; ++row) {
    for (int column = 0; column < 128; ++column) {
      if (inside(row, column)) {
        plane[static_cast<size_t>(row * 16 + column / 8)] |= static_cast<uint8_t>(1u << (column % 8));
      }
    }
  }
  return plane;
}

// Encodes, decodes, compares; the coded bytes.
size_t RoundTrip(const Plane& plane) {
  std::vector<std::byte> bytes(kMaxPlaneBits / 8 + 8);
  BitWriter writer(bytes);
  EncodePlane(plane, writer);
  bytes.resize(writer.Finish());
  EXPECT_LE(bytes.size(), size_t{kMaxPlaneBits / 8});
  Plane decoded;
  decoded.fill(0xa5);
  BitReader reader(bytes);
  EXPECT_TRUE(DecodePlane(reader, decoded));
  EXPECT_TRUE(reader.AtExactEnd());
  EXPECT_EQ(decoded, plane);
  return bytes.size();
}

TEST(PlaneCodec, EmptyAndFullPlanesCostOneBitARow) {
  EXPECT_EQ(RoundTrip(Paint([](int, int) { return false; })), 16u);
  EXPECT_LE(RoundTrip(Paint([](int, int) { return true; })), 19u);
}

TEST(PlaneCodec, StraightEdgesOfAnySlopeAreSmall) {
  for (const double slope : {-3.0, -1.0, -0.4, 0.0, 0.1, 0.9, 2.5}) {
    const size_t bytes = RoundTrip(Paint([&](int row, int column) {
      const double offset = column - 64 - slope * (row - 64);
      return offset > -8 && offset < 8;
    }));
    EXPECT_LE(bytes, 250u) << slope;
  }
}

TEST(PlaneCodec, SinglePixelsInEveryColumnSurvive) {
  for (int pixel = 0; pixel < 128; ++pixel) {
    RoundTrip(Paint([&](int row, int column) { return row == pixel && column == pixel; }));
    RoundTrip(Paint([&](int row, int column) { return row == 127 && column == pixel; }));
  }
}

TEST(PlaneCodec, NoiseTakesNoMoreThanItsBits) {
  Random random(7);
  for (int round = 0; round < 200; ++round) {
    const double density = random.Uniform();
    RoundTrip(Paint([&](int, int) { return random.Uniform() < density; }));
  }
}

TEST(PlaneCodec, EdgesOutOfOrderAreRefused) {
  std::vector<std::byte> bytes(64);
  BitWriter writer(bytes);
  writer.Put(0b100, 3);  // listed edges
  writer.Put(2, 8);
  writer.Put(20, 7);
  writer.Put(20, 7);
  writer.Finish();
  BitReader reader(bytes);
  Plane plane;
  EXPECT_FALSE(DecodePlane(reader, plane));
}

TEST(PlaneCodec, MoreEdgesThanColumnsAreRefused) {
  std::vector<std::byte> bytes(256, std::byte{0xff});
  BitWriter writer(bytes);
  writer.Put(0b100, 3);
  writer.Put(129, 8);
  writer.Finish();
  BitReader reader(bytes);
  Plane plane;
  EXPECT_FALSE(DecodePlane(reader, plane));
}

}  // namespace
}  // namespace dadrl
