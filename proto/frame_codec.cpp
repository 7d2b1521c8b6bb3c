// One frame's payload: a byte with the payload version (high six bits) and the float coding (low two: 0 fp16,
// 1 fp32), then one stream of bits: vehicle histories, ego histories (history_codec.h), context planes
// (plane_codec.h), zero bits up to a whole byte.
#include <cassert>
#include <span>

#include "proto/codec/history_codec.h"
#include "proto/codec/plane_codec.h"
#include "proto/experience.h"

namespace dadrl {
namespace {

constexpr int kPayloadVersion = 1;

constexpr std::byte Tag(FloatCoding coding) {
  return static_cast<std::byte>(kPayloadVersion << 2 | (coding == FloatCoding::kFloat32 ? 1 : 0));
}

}  // namespace

FloatCoding CodingOf(std::span<const std::byte> payload) {
  return payload.front() == Tag(FloatCoding::kFloat32) ? FloatCoding::kFloat32 : FloatCoding::kFloat16;
}

struct FrameCodec::Impl {
  Impl(const ObservationSpec& spec, FloatCoding coding)
      : vehicles{spec.vehicles, spec.history, ObservationSpec::kVehicleFeatures},
        ego{1, spec.history, ObservationSpec::kEgoFeatures},
        floats(coding) {
    assert(spec.history >= 1 && spec.history <= kMaxHistory && spec.vehicles >= 1);
    const size_t bits = MaxHistoryBits(vehicles) + MaxHistoryBits(ego) +
                        size_t{ObservationSpec::kContextPlanes} * kMaxPlaneBits;
    scratch.resize(bits / 8 + 8);
  }

  HistoryShape vehicles;
  HistoryShape ego;
  FloatCoding floats;
  std::vector<std::byte> scratch;  // holds the longest payload
};

FrameCodec::FrameCodec(const ObservationSpec& spec, FloatCoding floats)
    : impl_(std::make_unique<Impl>(spec, floats)) {}
FrameCodec::~FrameCodec() = default;
FrameCodec::FrameCodec(FrameCodec&&) noexcept = default;
FrameCodec& FrameCodec::operator=(FrameCodec&&) noexcept = default;

size_t FrameCodec::max_payload_bytes() const { return 1 + impl_->scratch.size(); }

void FrameCodec::Encode(const Observation& observation, std::vector<std::byte>& out) {
  BitWriter bits(impl_->scratch);
  EncodeHistories(observation.vehicles, impl_->vehicles, impl_->floats, bits);
  EncodeHistories(observation.ego, impl_->ego, impl_->floats, bits);
  const std::span context(observation.context);
  for (size_t plane = 0; plane < ObservationSpec::kContextPlanes; ++plane) {
    EncodePlane(context.subspan(plane * kPlaneBytes).first<kPlaneBytes>(), bits);
  }
  const size_t bytes = bits.Finish();
  out.push_back(Tag(impl_->floats));
  out.insert(out.end(), impl_->scratch.begin(), impl_->scratch.begin() + static_cast<ptrdiff_t>(bytes));
}

Status FrameCodec::Decode(std::span<const std::byte> payload, std::span<float> vehicles, std::span<float> ego,
                          std::span<uint8_t> context) {
  if (payload.empty()) return Fail(ErrorCode::kCorrupt, "frame payload is empty");
  const std::byte tag = payload.front();
  if (tag != Tag(FloatCoding::kFloat16) && tag != Tag(FloatCoding::kFloat32)) {
    return Fail(ErrorCode::kCorrupt, "frame payload starts with {:#04x}: another version",
                static_cast<int>(tag));
  }
  const FloatCoding floats = CodingOf(payload);
  BitReader bits(payload.subspan(1));
  if (!DecodeHistories(bits, impl_->vehicles, floats, vehicles) ||
      !DecodeHistories(bits, impl_->ego, floats, ego)) {
    return Fail(ErrorCode::kCorrupt, "frame payload holds a float that is not finite");
  }
  for (size_t plane = 0; plane < ObservationSpec::kContextPlanes; ++plane) {
    if (!DecodePlane(bits, context.subspan(plane * kPlaneBytes).first<kPlaneBytes>())) {
      return Fail(ErrorCode::kCorrupt, "frame payload: context plane {} has edges out of order", plane);
    }
  }
  if (!bits.AtExactEnd()) {
    return Fail(ErrorCode::kCorrupt, "frame payload of {} bytes is not exactly one frame of this spec",
                payload.size());
  }
  return {};
}

}  // namespace dadrl
