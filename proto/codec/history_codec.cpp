#include "proto/codec/history_codec.h"

#include <array>
#include <bit>
#include <cstdint>

#include "proto/codec/half.h"

namespace dadrl {
namespace {

// How one float coding maps to unsigned integers, whose order is that of the floats.
struct Float16 {
  static constexpr int kBits = 16;
  static constexpr int kWidthBits = 4;
  static constexpr uint32_t kMask = 0xffff;
  static constexpr uint32_t kSign = 0x8000;
  static constexpr uint32_t kInfinity = 0x7c00;
  static constexpr uint32_t kOne = 0x3c00;
  static uint32_t ToBits(float value) { return HalfFromFloat(value); }
  static float FromBits(uint32_t bits) { return FloatFromHalf(bits); }
};

struct Float32 {
  static constexpr int kBits = 32;
  static constexpr int kWidthBits = 5;
  static constexpr uint32_t kMask = 0xffffffff;
  static constexpr uint32_t kSign = 0x80000000;
  static constexpr uint32_t kInfinity = 0x7f800000;
  static constexpr uint32_t kOne = 0x3f800000;
  static uint32_t ToBits(float value) { return std::bit_cast<uint32_t>(value); }
  static float FromBits(uint32_t bits) { return std::bit_cast<float>(bits); }
};

template <typename Float>
uint32_t Ordered(uint32_t bits) {
  return (bits & Float::kSign) != 0 ? ~bits & Float::kMask : bits | Float::kSign;
}

template <typename Float>
uint32_t Unordered(uint32_t ordered) {
  return (ordered & Float::kSign) != 0 ? ordered & ~Float::kSign : ~ordered & Float::kMask;
}

template <typename Float>
uint32_t ZigZag(uint32_t difference) {
  const bool negative = (difference & Float::kSign) != 0;
  return ((difference << 1) ^ (negative ? Float::kMask : 0)) & Float::kMask;
}

template <typename Float>
uint32_t UnZigZag(uint32_t code) {
  return (code >> 1) ^ ((code & 1) != 0 ? Float::kMask : 0);
}

template <typename Float>
void PutNewest(uint32_t bits, BitWriter& out) {
  if (bits == 0) {
    out.Put(0, 2);
  } else if (bits == Float::kOne) {
    out.Put(1, 2);
  } else if (bits == (Float::kOne | Float::kSign)) {
    out.Put(2, 2);
  } else {
    out.Put(3, 2);
    out.Put(bits, Float::kBits);
  }
}

template <typename Float>
uint32_t GetNewest(BitReader& in) {
  switch (in.Get(2)) {
    case 0:
      return 0;
    case 1:
      return Float::kOne;
    case 2:
      return Float::kOne | Float::kSign;
    default:
      return in.Get(Float::kBits);
  }
}

// One feature of one entity: `history` values, `stride` apart, the newest last.
template <typename Float>
void EncodeColumn(const float* oldest, int history, int stride, BitWriter& out) {
  const auto bits_at = [&](int row) { return Float::ToBits(oldest[row * stride]); };
  const uint32_t newest = bits_at(history - 1);
  PutNewest<Float>(newest, out);
  std::array<uint32_t, kMaxHistoryRows> codes;
  size_t count = 0;
  uint32_t all = 0;
  uint32_t previous = Ordered<Float>(newest);
  for (int row = history - 2; row >= 0; --row) {
    const uint32_t ordered = Ordered<Float>(bits_at(row));
    codes[count] = ZigZag<Float>(ordered - previous);
    all |= codes[count++];
    previous = ordered;
  }
  if (all == 0) {
    out.Put(0, 1);
    return;
  }
  const int width = 32 - std::countl_zero(all);
  out.Put(1u | static_cast<uint32_t>(width - 1) << 1, 1 + Float::kWidthBits);
  for (size_t i = 0; i < count; ++i) out.Put(codes[i], width);
}

template <typename Float>
bool DecodeColumn(BitReader& in, int history, int stride, float* oldest) {
  uint32_t bits = GetNewest<Float>(in);
  uint32_t ordered = Ordered<Float>(bits);
  bool finite = (bits & ~Float::kSign) < Float::kInfinity;
  oldest[(history - 1) * stride] = Float::FromBits(bits);
  const bool constant = in.Get(1) == 0;
  const int width = constant ? 0 : 1 + static_cast<int>(in.Get(Float::kWidthBits));
  for (int row = history - 2; row >= 0; --row) {
    if (!constant) {
      ordered = (ordered + UnZigZag<Float>(in.Get(width))) & Float::kMask;
      bits = Unordered<Float>(ordered);
      finite &= (bits & ~Float::kSign) < Float::kInfinity;
    }
    oldest[row * stride] = Float::FromBits(bits);
  }
  return finite;
}

template <typename Float>
void Encode(std::span<const float> values, const HistoryShape& shape, BitWriter& out) {
  for (int entity = 0; entity < shape.entities; ++entity) {
    for (int feature = 0; feature < shape.features; ++feature) {
      const float* oldest = values.data() + entity * shape.history * shape.features + feature;
      EncodeColumn<Float>(oldest, shape.history, shape.features, out);
    }
  }
}

template <typename Float>
bool Decode(BitReader& in, const HistoryShape& shape, std::span<float> values) {
  bool finite = true;
  for (int entity = 0; entity < shape.entities; ++entity) {
    for (int feature = 0; feature < shape.features; ++feature) {
      float* oldest = values.data() + entity * shape.history * shape.features + feature;
      finite &= DecodeColumn<Float>(in, shape.history, shape.features, oldest);
    }
  }
  return finite;
}

}  // namespace

size_t MaxHistoryBits(const HistoryShape& shape) {
  const size_t column = 2 + 1 + Float32::kWidthBits + static_cast<size_t>(shape.history) * Float32::kBits;
  return static_cast<size_t>(shape.entities) * static_cast<size_t>(shape.features) * column;
}

void EncodeHistories(std::span<const float> values, const HistoryShape& shape, FloatCoding coding,
                     BitWriter& out) {
  if (coding == FloatCoding::kFloat16) {
    Encode<Float16>(values, shape, out);
  } else {
    Encode<Float32>(values, shape, out);
  }
}

bool DecodeHistories(BitReader& in, const HistoryShape& shape, FloatCoding coding, std::span<float> values) {
  return coding == FloatCoding::kFloat16 ? Decode<Float16>(in, shape, values)
                                         : Decode<Float32>(in, shape, values);
}

}  // namespace dadrl
