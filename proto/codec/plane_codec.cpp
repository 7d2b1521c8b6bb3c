#include "proto/codec/plane_codec.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>

namespace dadrl {
namespace {

constexpr int kSize = kBitPlaneSide;
constexpr int kRowBytes = kSize / 8;
static_assert(kSize == 128, "a row is two 64-bit words");

struct Row {
  uint64_t low = 0;
  uint64_t high = 0;
  bool operator==(const Row&) const = default;
};

// Columns at which the colour differs from the column before; column -1 is 0.
struct Edges {
  size_t count = 0;
  std::array<uint8_t, kSize> columns;

  void Append(uint64_t changes, int first_column) {
    for (; changes != 0; changes &= changes - 1) {
      columns[count++] = first_column + std::countr_zero(changes);
    }
  }
  void From(const Row& row) {
    count = 0;
    Append(row.low ^ (row.low << 1), 0);
    Append(row.high ^ (row.high << 1 | row.low >> 63), 64);
  }
  Row ToRow() const {
    Row row;
    for (size_t i = 0; i < count; ++i) {
      const int column = columns[i];
      if (column < 64) {
        row.low ^= ~uint64_t{0} << column;
        row.high = ~row.high;
      } else {
        row.high ^= ~uint64_t{0} << (column - 64);
      }
    }
    return row;
  }
};

int ShiftBits(int shift) {
  const int distance = std::abs(shift);
  if (distance == 0) return 1;
  if (distance <= 2) return 2 + distance;
  return distance <= 6 ? 7 : 12;
}

void PutShift(int shift, BitWriter& out) {
  const auto distance = static_cast<uint32_t>(std::abs(shift));
  const uint32_t sign = shift < 0 ? 1 : 0;
  if (distance == 0) {
    out.Put(0, 1);
  } else if (distance == 1) {
    out.Put(0b01 | sign << 2, 3);
  } else if (distance == 2) {
    out.Put(0b011 | sign << 3, 4);
  } else if (distance <= 6) {
    out.Put(0b0111 | sign << 4 | (distance - 3) << 5, 7);
  } else {
    out.Put(0b1111 | static_cast<uint32_t>(shift + kSize) << 4, 12);
  }
}

int GetShift(BitReader& in) {
  const uint32_t bits = in.Peek(12);
  const int ones = std::countr_one(bits & 0xf);
  int distance = 0;
  switch (ones) {
    case 0:
      in.Skip(1);
      return 0;
    case 1:
    case 2:
      in.Skip(2 + ones);
      distance = ones;
      break;
    case 3:
      in.Skip(7);
      distance = 3 + static_cast<int>(bits >> 5 & 3);
      break;
    default:
      in.Skip(12);
      return static_cast<int>(bits >> 4) - kSize;
  }
  return (bits >> (ones + 1) & 1) != 0 ? -distance : distance;
}

// Bits of coding `edges` by shifts of `above`; their number must agree.
int ShiftedBits(const Edges& edges, const Edges& above) {
  int bits = 2;
  for (size_t i = 0; i < edges.count; ++i) {
    bits += ShiftBits(edges.columns[i] - above.columns[i]);
  }
  return bits;
}

void PutRow(const Row& row, const Edges& edges, const Edges& above, BitWriter& out) {
  const int listed_bits = 3 + 8 + 7 * edges.count;
  const int shifted_bits = edges.count == above.count ? ShiftedBits(edges, above) : kMaxPlaneBits;
  if (std::min(listed_bits, shifted_bits) >= kSize + 3) {
    out.Put(0b000, 3);
    for (const uint64_t word : {row.low, row.high}) {
      out.Put(word & 0xffffffff, 32);
      out.Put(word >> 32, 32);
    }
  } else if (shifted_bits <= listed_bits) {
    out.Put(0b10, 2);
    for (size_t i = 0; i < edges.count; ++i) {
      PutShift(edges.columns[i] - above.columns[i], out);
    }
  } else {
    out.Put(0b100, 3);
    out.Put(edges.count, 8);
    for (size_t i = 0; i < edges.count; ++i) out.Put(edges.columns[i], 7);
  }
}

// Reads the edges of one row over those of the row above. False when they are out of order or range.
bool GetShiftedEdges(BitReader& in, Edges& edges) {
  int previous = -1;
  for (size_t i = 0; i < edges.count; ++i) {
    const int column = edges.columns[i] + GetShift(in);
    if (column <= previous || column >= kSize) return false;
    edges.columns[i] = column;
    previous = column;
  }
  return true;
}

bool GetListedEdges(BitReader& in, Edges& edges) {
  const uint32_t count = in.Get(8);
  if (count > kSize) return false;
  edges.count = count;
  uint32_t least = 0;
  for (size_t i = 0; i < count; ++i) {
    const uint32_t column = in.Get(7);
    if (column < least) return false;
    edges.columns[i] = column;
    least = column + 1;
  }
  return true;
}

}  // namespace

void EncodePlane(std::span<const uint8_t, kPlaneBytes> plane, BitWriter& out) {
  Row above;
  std::array<Edges, 2> edges;
  Edges* now = &edges[0];
  Edges* before = &edges[1];
  for (int y = 0; y < kSize; ++y) {
    Row row;
    std::memcpy(&row, plane.data() + y * kRowBytes, kRowBytes);
    if (row == above) {
      out.Put(1, 1);
      continue;
    }
    now->From(row);
    PutRow(row, *now, *before, out);
    std::swap(now, before);
    above = row;
  }
}

bool DecodePlane(BitReader& in, std::span<uint8_t, kPlaneBytes> plane) {
  Row row;
  Edges edges;
  for (int y = 0; y < kSize; ++y) {
    const uint32_t mode = in.Peek(3);
    if ((mode & 1) != 0) {
      in.Skip(1);
    } else if ((mode & 2) != 0) {
      in.Skip(2);
      if (!GetShiftedEdges(in, edges)) return false;
      row = edges.ToRow();
    } else if (mode == 4) {
      in.Skip(3);
      if (!GetListedEdges(in, edges)) return false;
      row = edges.ToRow();
    } else {
      in.Skip(3);
      row.low = in.Get(32);
      row.low |= uint64_t{in.Get(32)} << 32;
      row.high = in.Get(32);
      row.high |= uint64_t{in.Get(32)} << 32;
      edges.From(row);
    }
    std::memcpy(plane.data() + y * kRowBytes, &row, kRowBytes);
  }
  return true;
}

}  // namespace dadrl
