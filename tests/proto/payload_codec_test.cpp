#include "proto/payload_codec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "proto/codec/half.h"
#include "tests/driving_columns.h"
#include "tests/proto/synthetic_experience.h"

namespace dadrl {
namespace {

Status DecodeInto(PayloadCodec& codec, std::span<const std::byte> payload, Observation& observation) {
  return codec.Decode(payload, observation);
}

std::vector<float> ThroughHalf(std::span<const float> exact) {
  std::vector<float> values(exact.begin(), exact.end());
  for (float& value : values) value = FloatFromHalf(HalfFromFloat(value));
  return values;
}

// Whatever is finite is taken.
StepSpec Unbounded(const DrivingShape& shape) {
  StepSpec spec = shape;
  for (ColumnSpec& column : spec.observation) column.bound = std::numeric_limits<float>::max();
  return spec;
}

class PayloadCodecOfSpec : public testing::TestWithParam<DrivingShape> {};
INSTANTIATE_TEST_SUITE_P(Specs, PayloadCodecOfSpec,
                         testing::Values(DrivingShape{6, 5}, DrivingShape{1, 1}, DrivingShape{64, 50}));

TEST_P(PayloadCodecOfSpec, Float32IsLossless) {
  PayloadCodec codec(Unbounded(GetParam()), FloatCoding::kFloat32);
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

TEST_P(PayloadCodecOfSpec, Float16RoundsToHalfAndNothingElse) {
  PayloadCodec codec(Unbounded(GetParam()), FloatCoding::kFloat16);
  Random random(2);
  for (int round = 0; round < 40; ++round) {
    const Observation observation =
        round % 2 == 0 ? SyntheticObservation(GetParam(), random) : NoiseObservation(GetParam(), random);
    std::vector<std::byte> payload;
    codec.Encode(observation, payload);
    Observation decoded(GetParam());
    ASSERT_TRUE(DecodeInto(codec, payload, decoded));
    EXPECT_THAT(VehiclesOf(decoded), testing::ElementsAreArray(ThroughHalf(VehiclesOf(observation))));
    EXPECT_THAT(EgoOf(decoded), testing::ElementsAreArray(ThroughHalf(EgoOf(observation))));
    EXPECT_TRUE(std::ranges::equal(ContextOf(decoded), ContextOf(observation)));
  }
}

TEST(PayloadCodec, KeepsTheSignOfZero) {
  const DrivingShape spec;
  PayloadCodec codec(spec, FloatCoding::kFloat32);
  Observation observation(spec);
  EgoOf(observation)[3] = -0.0f;
  std::vector<std::byte> payload;
  codec.Encode(observation, payload);
  Observation decoded(spec);
  ASSERT_TRUE(DecodeInto(codec, payload, decoded));
  EXPECT_TRUE(std::signbit(EgoOf(decoded)[3]));
  EXPECT_FALSE(std::signbit(EgoOf(decoded)[4]));
}

TEST(PayloadCodec, AppendsBehindWhatIsThere) {
  const DrivingShape spec;
  PayloadCodec codec(spec, FloatCoding::kFloat16);
  Random random(3);
  std::vector<std::byte> payload(5, std::byte{9});
  codec.Encode(SyntheticObservation(spec, random), payload);
  EXPECT_EQ(payload[4], std::byte{9});
  Observation decoded(spec);
  EXPECT_TRUE(DecodeInto(codec, std::span(payload).subspan(5), decoded));
}

TEST(PayloadCodec, ADecoderOfEitherCodingReadsBoth) {
  const DrivingShape spec;
  PayloadCodec half(spec, FloatCoding::kFloat16);
  PayloadCodec full(spec, FloatCoding::kFloat32);
  Random random(4);
  const Observation observation = SyntheticObservation(spec, random);
  std::vector<std::byte> payload;
  full.Encode(observation, payload);
  Observation decoded(spec);
  ASSERT_TRUE(DecodeInto(half, payload, decoded));
  EXPECT_EQ(decoded, observation);
}

TEST(PayloadCodec, RefusesFloatsThatAreNotFinite) {
  const StepSpec spec = Unbounded({});
  for (const FloatCoding coding : {FloatCoding::kFloat16, FloatCoding::kFloat32}) {
    for (const float bad :
         {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
      PayloadCodec codec(spec, coding);
      Observation observation(spec);
      VehiclesOf(observation)[17] = bad;
      std::vector<std::byte> payload;
      codec.Encode(observation, payload);
      Observation decoded(spec);
      const Status status = DecodeInto(codec, payload, decoded);
      ASSERT_FALSE(status);
      EXPECT_EQ(status.error().code, ErrorCode::kCorrupt);
    }
  }
}

TEST(PayloadCodec, RefusesNumbersBeyondTheBoundOfTheirColumn) {
  const DrivingShape spec;
  PayloadCodec codec(spec, FloatCoding::kFloat32);
  Observation decoded(spec);
  for (const float value : {5.0f, -5.0f, 5.001f, -65504.0f}) {
    Observation observation(spec);
    EgoOf(observation)[7] = value;
    std::vector<std::byte> payload;
    codec.Encode(observation, payload);
    const Status status = DecodeInto(codec, payload, decoded);
    EXPECT_EQ(status.has_value(), std::abs(value) <= 5.0f) << value;
    if (!status)
      EXPECT_THAT(status.error().message, testing::HasSubstr("column ego holds a number beyond 5"));
  }
}

// One column of each codec, in an order of its own.
TEST(PayloadCodec, EachCodecKeepsItsColumn) {
  const StepSpec spec{.observation = {{"bits", ElementType::kBit, {13}, ColumnCodec::kRaw},
                                      {"halves", ElementType::kFloat32, {2, 3}, ColumnCodec::kHalf},
                                      {"planes", ElementType::kBit, {1, 128, 128}, ColumnCodec::kBitPlanes},
                                      {"gap", ElementType::kFloat32, {}, ColumnCodec::kRaw},
                                      {"history", ElementType::kFloat32, {4, 5}, ColumnCodec::kHistory}},
                      .decision = {{"action", ElementType::kFloat32, {1}}}};
  ASSERT_TRUE(CheckSpec(spec));
  PayloadCodec codec(spec, FloatCoding::kFloat32);
  Random random(8);
  Observation observation(spec);
  for (size_t i = 0; i < spec.observation.size(); ++i) {
    for (float& value : observation.floats(i))
      value = FloatFromHalf(HalfFromFloat(static_cast<float>(random.Normal())));
    for (uint8_t& byte : observation.bits(i)) byte = static_cast<uint8_t>(random.Next());
  }
  std::vector<std::byte> payload;
  codec.Encode(observation, payload);
  EXPECT_LE(payload.size(), codec.max_payload_bytes());
  Observation decoded(spec);
  ASSERT_TRUE(DecodeInto(codec, payload, decoded));
  EXPECT_EQ(decoded, observation);
  payload.pop_back();
  EXPECT_FALSE(DecodeInto(codec, payload, decoded));
}

TEST(PayloadCodec, RefusesEveryTruncationAndAnyExtraByte) {
  const DrivingShape spec;
  PayloadCodec codec(spec, FloatCoding::kFloat16);
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

TEST(PayloadCodec, RefusesAnotherPayloadVersion) {
  const DrivingShape spec;
  PayloadCodec codec(spec, FloatCoding::kFloat16);
  std::vector<std::byte> payload;
  codec.Encode(Observation(spec), payload);
  payload[0] ^= std::byte{0x10};
  Observation decoded(spec);
  const Status status = DecodeInto(codec, payload, decoded);
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().message, testing::HasSubstr("version"));
}

TEST(PayloadCodec, ADrivingFrameStaysUnderItsBudget) {
  const DrivingShape spec;
  PayloadCodec codec(spec, FloatCoding::kFloat16);
  Random random(6);
  std::vector<std::byte> payloads;
  constexpr int kFrames = 500;
  for (int i = 0; i < kFrames; ++i) codec.Encode(SyntheticObservation(spec, random), payloads);
  EXPECT_LE(payloads.size() / kFrames, 800u);
}

}  // namespace
}  // namespace dadrl
