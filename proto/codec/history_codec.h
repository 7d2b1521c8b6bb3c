// Coding of histories of floats, [entities, history, features]: a feature of an entity changes little from
// one row to the next, and much of it is exactly 0 or 1.
//
// Per entity and feature, newest row first:
//   00 newest is 0 | 01 newest is 1 | 10 newest is -1 | 11 + its bits
//   0 all rows equal | 1 + (width - 1), then history - 1 differences of `width` bits
// Differences are between the floats' ordered integers, modulo 2^bits, zigzag coded: lossless for every bit
// pattern.
#pragma once

#include <cstddef>
#include <span>

#include "common/config/config.h"
#include "common/step/step_spec.h"
#include "proto/codec/bit_stream.h"

namespace dadrl {

struct HistoryShape {
  int entities = 0;
  int history = 0;  // 1 to kMaxHistoryRows
  int features = 0;
};

// Most bits that EncodeHistories puts.
size_t MaxHistoryBits(const HistoryShape& shape);

// fp16 rounds (half.h); fp32 keeps every bit.
void EncodeHistories(std::span<const float> values, const HistoryShape& shape, FloatCoding coding,
                     BitWriter& out);

// False when a value is not finite; `values` is then unspecified.
bool DecodeHistories(BitReader& in, const HistoryShape& shape, FloatCoding coding, std::span<float> values);

}  // namespace dadrl
