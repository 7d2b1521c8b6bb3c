// A payload: a byte with its version (high six bits) and the float coding of histories (low two: 0 fp16,
// 1 fp32), then one stream of bits, column after column, and zero bits up to a whole byte.
#include "proto/payload_codec.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

#include "proto/codec/half.h"
#include "proto/codec/history_codec.h"
#include "proto/codec/plane_codec.h"

namespace dadrl {
namespace {

constexpr int kPayloadVersion = 1;

constexpr std::byte Tag(FloatCoding coding) {
  return static_cast<std::byte>(kPayloadVersion << 2 | (coding == FloatCoding::kFloat32 ? 1 : 0));
}

HistoryShape HistoryOf(const ColumnSpec& column) {
  const std::vector<int>& shape = column.shape;
  return {.entities = shape.size() == 3 ? shape[0] : 1,
          .history = shape[shape.size() - 2],
          .features = shape.back()};
}

// One of a column's codecs. Values are of one row.
struct Coder {
  size_t (*max_bits)(const ColumnSpec& column);
  void (*encode)(const ColumnSpec& column, FloatCoding floats, const ColumnRows& row, size_t index,
                 BitWriter& out);
  // False when the bits are no such column.
  bool (*decode)(const ColumnSpec& column, FloatCoding floats, BitReader& in, const MutableColumnRows& row,
                 size_t index);
};

bool AllFinite(std::span<const float> values) {
  return std::ranges::all_of(values, [](float value) { return std::isfinite(value); });
}

constexpr Coder kRaw = {
    .max_bits = [](const ColumnSpec& column) { return 8 * column.bytes(); },
    .encode =
        [](const ColumnSpec&, FloatCoding, const ColumnRows& row, size_t index, BitWriter& out) {
          for (const float value : row.floats(index)) out.Put(std::bit_cast<uint32_t>(value), 32);
          for (const uint8_t byte : row.bits(index)) out.Put(byte, 8);
        },
    .decode =
        [](const ColumnSpec&, FloatCoding, BitReader& in, const MutableColumnRows& row, size_t index) {
          for (float& value : row.floats(index)) value = std::bit_cast<float>(in.Get(32));
          for (uint8_t& byte : row.bits(index)) byte = in.Get(8);
          return AllFinite(row.floats(index));
        }};

constexpr Coder kHalf = {
    .max_bits = [](const ColumnSpec& column) { return 16 * column.elements(); },
    .encode =
        [](const ColumnSpec&, FloatCoding, const ColumnRows& row, size_t index, BitWriter& out) {
          for (const float value : row.floats(index)) out.Put(HalfFromFloat(value), 16);
        },
    .decode =
        [](const ColumnSpec&, FloatCoding, BitReader& in, const MutableColumnRows& row, size_t index) {
          for (float& value : row.floats(index)) value = FloatFromHalf(in.Get(16));
          return AllFinite(row.floats(index));
        }};

constexpr Coder kHistory = {
    .max_bits = [](const ColumnSpec& column) { return MaxHistoryBits(HistoryOf(column)); },
    .encode = [](const ColumnSpec& column, FloatCoding floats, const ColumnRows& row, size_t index,
                 BitWriter& out) { EncodeHistories(row.floats(index), HistoryOf(column), floats, out); },
    .decode = [](const ColumnSpec& column, FloatCoding floats, BitReader& in, const MutableColumnRows& row,
                 size_t index) { return DecodeHistories(in, HistoryOf(column), floats, row.floats(index)); }};

constexpr Coder kBitPlanes = {
    .max_bits =
        [](const ColumnSpec& column) { return static_cast<size_t>(column.shape[0]) * size_t{kMaxPlaneBits}; },
    .encode =
        [](const ColumnSpec&, FloatCoding, const ColumnRows& row, size_t index, BitWriter& out) {
          for (auto rest = row.bits(index); !rest.empty(); rest = rest.subspan(kPlaneBytes)) {
            EncodePlane(rest.first<kPlaneBytes>(), out);
          }
        },
    .decode =
        [](const ColumnSpec&, FloatCoding, BitReader& in, const MutableColumnRows& row, size_t index) {
          for (auto rest = row.bits(index); !rest.empty(); rest = rest.subspan(kPlaneBytes)) {
            if (!DecodePlane(in, rest.first<kPlaneBytes>())) return false;
          }
          return true;
        }};

const Coder& CoderOf(ColumnCodec codec) {
  switch (codec) {
    case ColumnCodec::kHalf:
      return kHalf;
    case ColumnCodec::kHistory:
      return kHistory;
    case ColumnCodec::kBitPlanes:
      return kBitPlanes;
    case ColumnCodec::kRaw:
      break;
  }
  return kRaw;
}

bool AllWithin(std::span<const float> values, float bound) {
  // All of them are looked at, several at once: hardly ever is one beyond.
  bool within = true;
  for (const float value : values) within &= std::abs(value) <= bound;
  return within;
}

}  // namespace

FloatCoding CodingOf(std::span<const std::byte> payload) {
  return payload.front() == Tag(FloatCoding::kFloat32) ? FloatCoding::kFloat32 : FloatCoding::kFloat16;
}

struct PayloadCodec::Impl {
  std::vector<ColumnSpec> columns;
  FloatCoding floats;
  std::vector<std::byte> scratch;  // holds the longest payload
};

PayloadCodec::PayloadCodec(const StepSpec& spec, FloatCoding floats)
    : impl_(std::make_unique<Impl>(Impl{spec.observation, floats, {}})) {
  assert(CheckSpec(spec));
  size_t bits = 0;
  for (const ColumnSpec& column : impl_->columns) bits += CoderOf(column.codec).max_bits(column);
  impl_->scratch.resize(bits / 8 + 8);
}
PayloadCodec::~PayloadCodec() = default;
PayloadCodec::PayloadCodec(PayloadCodec&&) noexcept = default;
PayloadCodec& PayloadCodec::operator=(PayloadCodec&&) noexcept = default;

size_t PayloadCodec::max_payload_bytes() const { return 1 + impl_->scratch.size(); }

void PayloadCodec::Encode(ColumnRows row, std::vector<std::byte>& out) {
  BitWriter bits(impl_->scratch);
  for (size_t i = 0; i < impl_->columns.size(); ++i) {
    const ColumnSpec& column = impl_->columns[i];
    CoderOf(column.codec).encode(column, impl_->floats, row, i, bits);
  }
  const size_t bytes = bits.Finish();
  out.push_back(Tag(impl_->floats));
  out.insert(out.end(), impl_->scratch.begin(), impl_->scratch.begin() + static_cast<ptrdiff_t>(bytes));
}

Status PayloadCodec::Decode(std::span<const std::byte> payload, MutableColumnRows row) {
  if (payload.empty()) return Fail(ErrorCode::kCorrupt, "payload is empty");
  const std::byte tag = payload.front();
  if (tag != Tag(FloatCoding::kFloat16) && tag != Tag(FloatCoding::kFloat32)) {
    return Fail(ErrorCode::kCorrupt, "payload starts with {:#04x}: another version", static_cast<int>(tag));
  }
  BitReader bits(payload.subspan(1));
  for (size_t i = 0; i < impl_->columns.size(); ++i) {
    const ColumnSpec& column = impl_->columns[i];
    if (!CoderOf(column.codec).decode(column, CodingOf(payload), bits, row, i)) {
      return Fail(
          ErrorCode::kCorrupt, "payload: column {} holds {}", column.name,
          column.codec == ColumnCodec::kBitPlanes ? "edges out of order" : "a number that is not finite");
    }
    if (!AllWithin(row.floats(i), column.bound)) {
      return Fail(ErrorCode::kCorrupt, "payload: column {} holds a number beyond {:g}, its bound",
                  column.name, column.bound);
    }
  }
  if (!bits.AtExactEnd()) {
    return Fail(ErrorCode::kCorrupt, "payload of {} bytes is not exactly one of this spec", payload.size());
  }
  return {};
}

}  // namespace dadrl
