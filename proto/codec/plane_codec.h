// Lossless coding of one 128 x 128 bit plane by its edges: in a bird's-eye view the columns where a row
// changes colour hardly move from one row to the next.
//
// Row by row against the row above (the first against an empty one), the cheapest of
//   1                         the same row
//   01  one code an edge      the same number of edges, each shifted: 0 | 10s | 110s | 1110smm | 1111 + 8
//   bits 001 count, columns        other edges: 8 bits, then 7 bits each 000 128 bits              the row as
//   it is
// so that no plane takes more than 131 bits a row.
#pragma once

#include <cstdint>
#include <span>

#include "common/step/step_spec.h"
#include "proto/codec/bit_stream.h"

namespace dadrl {

constexpr int kPlaneBytes = kBitPlaneSide * kBitPlaneSide / 8;
constexpr int kMaxPlaneBits = kBitPlaneSide * (kBitPlaneSide + 3);

// `plane` row by row, the first pixel in the lowest bit.
void EncodePlane(std::span<const uint8_t, kPlaneBytes> plane, BitWriter& out);

// False when the bits are no plane; `plane` is then unspecified.
bool DecodePlane(BitReader& in, std::span<uint8_t, kPlaneBytes> plane);

}  // namespace dadrl
