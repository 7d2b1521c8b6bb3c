#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "proto/codec/half.h"
#include "proto/experience.h"
#include "tests/proto/synthetic_experience.h"

namespace dadrl {
namespace {

Status DecodeInto(FrameCodec& codec, std::span<const std::byte> payload, Observation& observation) {
  return codec.Decode(payload, observation.vehicles, observation.ego, observation.context);
}

std::vector<float> ThroughHalf(std::vector<float> values) {
  for (float& value : values) value = FloatFromHalf(HalfFromFloat(value));
  return values;
}

class FrameCodecOfSpec : public testing::TestWithParam<ObservationSpec> {};
INSTANTIATE_TEST_SUITE_P(Specs, FrameCodecOfSpec,
                         testing::Values(ObservationSpec{6, 5}, ObservationSpec{1, 1},
                                         ObservationSpec{64, 50}));

TEST_P(FrameCodecOfSpec, Float32IsLossless) {
  FrameCodec codec(GetParam(), FloatCoding::kFloat32);
  Random random(1);
  for (int round = 0; round < 40; ++round) {
    const Observation observation =
        round % 2 == 0 ? SyntheticObservation(GetParam(), random) : NoiseObservation(GetParam(), random);
    std::vector<std::byte> payload;
    codec.Encode(observation, payload);
    EXPECT_LE(payload.size(), codec.max_payload_bytes());
    Observation decoded(GetParam());
    ASSERT_TRUE(DecodeInto(codec, payload, decoded));
    EXPECT_EQ(decoded, observation);
  }
}

TEST_P(FrameCodecOfSpec, Float16RoundsToHalfAndNothingElse) {
  FrameCodec codec(GetParam(), FloatCoding::kFloat16);
  Random random(2);
  for (int round = 0; round < 40; ++round) {
    const Observation observation =
        round % 2 == 0 ? SyntheticObservation(GetParam(), random) : NoiseObservation(GetParam(), random);
    std::vector<std::byte> payload;
    codec.Encode(observation, payload);
    Observation decoded(GetParam());
    ASSERT_TRUE(DecodeInto(codec, payload, decoded));
    EXPECT_EQ(decoded.vehicles, ThroughHalf(observation.vehicles));
    EXPECT_EQ(decoded.ego, ThroughHalf(observation.ego));
    EXPECT_EQ(decoded.context, observation.context);
  }
}

TEST(FrameCodec, KeepsTheSignOfZero) {
  const ObservationSpec spec;
  FrameCodec codec(spec, FloatCoding::kFloat32);
  Observation observation(spec);
  observation.ego[3] = -0.0f;
  std::vector<std::byte> payload;
  codec.Encode(observation, payload);
  Observation decoded(spec);
  ASSERT_TRUE(DecodeInto(codec, payload, decoded));
  EXPECT_TRUE(std::signbit(decoded.ego[3]));
  EXPECT_FALSE(std::signbit(decoded.ego[4]));
}

TEST(FrameCodec, AppendsBehindWhatIsThere) {
  const ObservationSpec spec;
  FrameCodec codec(spec, FloatCoding::kFloat16);
  Random random(3);
  std::vector<std::byte> payload(5, std::byte{9});
  codec.Encode(SyntheticObservation(spec, random), payload);
  EXPECT_EQ(payload[4], std::byte{9});
  Observation decoded(spec);
  EXPECT_TRUE(DecodeInto(codec, std::span(payload).subspan(5), decoded));
}

TEST(FrameCodec, ADecoderOfEitherCodingReadsBoth) {
  const ObservationSpec spec;
  FrameCodec half(spec, FloatCoding::kFloat16);
  FrameCodec full(spec, FloatCoding::kFloat32);
  Random random(4);
  const Observation observation = SyntheticObservation(spec, random);
  std::vector<std::byte> payload;
  full.Encode(observation, payload);
  Observation decoded(spec);
  ASSERT_TRUE(DecodeInto(half, payload, decoded));
  EXPECT_EQ(decoded, observation);
}

TEST(FrameCodec, RefusesFloatsThatAreNotFinite) {
  const ObservationSpec spec;
  for (const FloatCoding coding : {FloatCoding::kFloat16, FloatCoding::kFloat32}) {
    for (const float bad :
         {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
      FrameCodec codec(spec, coding);
      Observation observation(spec);
      observation.vehicles[17] = bad;
      std::vector<std::byte> payload;
      codec.Encode(observation, payload);
      Observation decoded(spec);
      const Status status = DecodeInto(codec, payload, decoded);
      ASSERT_FALSE(status);
      EXPECT_EQ(status.error().code, ErrorCode::kCorrupt);
    }
  }
}

TEST(FrameCodec, RefusesEveryTruncationAndAnyExtraByte) {
  const ObservationSpec spec;
  FrameCodec codec(spec, FloatCoding::kFloat16);
  Random random(5);
  std::vector<std::byte> payload;
  codec.Encode(SyntheticObservation(spec, random), payload);
  Observation decoded(spec);
  for (size_t length = 0; length < payload.size(); ++length) {
    // Exactly sized copies, so that a read outside is one that sanitizers see.
    const std::vector<std::byte> cut(payload.begin(), payload.begin() + static_cast<ptrdiff_t>(length));
    EXPECT_FALSE(DecodeInto(codec, cut, decoded)) << length;
  }
  payload.push_back(std::byte{0});
  EXPECT_FALSE(DecodeInto(codec, payload, decoded));
}

TEST(FrameCodec, RefusesAnotherPayloadVersion) {
  const ObservationSpec spec;
  FrameCodec codec(spec, FloatCoding::kFloat16);
  std::vector<std::byte> payload;
  codec.Encode(Observation(spec), payload);
  payload[0] ^= std::byte{0x10};
  Observation decoded(spec);
  const Status status = DecodeInto(codec, payload, decoded);
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().message, testing::HasSubstr("version"));
}

TEST(FrameCodec, ADrivingFrameStaysUnderItsBudget) {
  const ObservationSpec spec;
  FrameCodec codec(spec, FloatCoding::kFloat16);
  Random random(6);
  std::vector<std::byte> payloads;
  constexpr int kFrames = 500;
  for (int i = 0; i < kFrames; ++i) codec.Encode(SyntheticObservation(spec, random), payloads);
  EXPECT_LE(payloads.size() / kFrames, 800u);
}

}  // namespace
}  // namespace dadrl
