#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "common/io/checksum.h"
#include "proto/experience.h"
#include "tests/driving_columns.h"
#include "tests/proto/synthetic_experience.h"

namespace dadrl {
namespace {

const DrivingShape kSpec;

std::vector<std::byte> SmallChunk() {
  return MakeSyntheticChunk(kSpec,
                            {.identity = {3, 1700000000, 5}, .episode = 9, .first_frame = 64, .frames = 2});
}

// Replaces a value and mends the checksum: what a faulty writer would send.
template <typename T>
std::vector<std::byte> Forged(std::vector<std::byte> bytes, size_t at, T value) {
  std::memcpy(&bytes[at], &value, sizeof(T));
  const uint64_t checksum = Xxh3(std::span(bytes).first(bytes.size() - 8));
  std::memcpy(&bytes[bytes.size() - 8], &checksum, 8);
  return bytes;
}

std::string ErrorOf(const std::vector<std::byte>& bytes) {
  const auto view = ChunkView::Parse(bytes);
  if (view) return "";
  EXPECT_EQ(view.error().code, ErrorCode::kCorrupt);
  return view.error().message;
}

// Offsets of the wire format of a chunk of two frames.
constexpr size_t kFrames = 16;
constexpr size_t kSequence = 32;
constexpr size_t kColumns = 56;
constexpr size_t kActions = kColumns + 2 * 4;
constexpr size_t kRewards = kActions + 2 * 8;
constexpr size_t kFlags = kRewards + 2 * 4;
constexpr size_t kOffsets = kFlags + 4;

TEST(Chunk, ComesBackAsItWasBuilt) {
  Random random(1);
  std::vector<Observation> observations;
  ChunkBuilder builder(kSpec, FloatCoding::kFloat32);
  builder.Begin(/*episode=*/77, /*first_frame=*/128);
  for (int i = 0; i < 5; ++i) {
    observations.push_back(SyntheticObservation(kSpec, random));
    builder.AddTransition(observations.back(), Action{0.25f * static_cast<float>(i), -0.5f},
                          static_cast<float>(i) - 2.0f, static_cast<uint8_t>(i == 4 ? kTruncated : 0),
                          static_cast<uint32_t>(10 + i));
  }
  observations.push_back(SyntheticObservation(kSpec, random));
  builder.AddFinal(observations.back());
  const std::vector<std::byte> bytes = builder.Finish({4, 12345, 6});

  const auto view = ChunkView::Parse(bytes);
  ASSERT_TRUE(view) << view.error().message;
  EXPECT_EQ(view->header().identity, (ChunkIdentity{4, 12345, 6}));
  EXPECT_EQ(view->header().episode, 77u);
  EXPECT_EQ(view->header().first_frame, 128u);
  EXPECT_EQ(view->header().schema, SchemaHash(kSpec));
  ASSERT_EQ(view->frames(), 6);
  PayloadCodec codec(kSpec, FloatCoding::kFloat16);
  for (int i = 0; i < 6; ++i) {
    Observation decoded(kSpec);
    ASSERT_TRUE(codec.Decode(view->payload(i), decoded));
    EXPECT_EQ(decoded, observations[static_cast<size_t>(i)]);
  }
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(view->flags(i), kHasDecision | (i == 4 ? kTruncated : 0));
    EXPECT_EQ(view->decision(i, 0), 0.25f * static_cast<float>(i));
    EXPECT_EQ(view->decision(i, 1), -0.5f);
    EXPECT_EQ(view->reward(i), static_cast<float>(i) - 2.0f);
    EXPECT_EQ(view->policy_version(i), static_cast<uint32_t>(10 + i));
  }
  EXPECT_EQ(view->flags(5), 0);
}

TEST(Chunk, AFullChunkOfDrivingStaysUnderAKilobyteAFrame) {
  const auto bytes = MakeSyntheticChunk(kSpec, {.identity = {1, 1, 1}});
  EXPECT_LE(bytes.size() / 64, 1000u);
}

TEST(Chunk, TheBuilderIsFullAtItsFrameLimitAndBeforeItsByteLimit) {
  Random random(2);
  ChunkBuilder builder(kSpec, FloatCoding::kFloat16);
  const Observation observation = SyntheticObservation(kSpec, random);
  while (!builder.full()) builder.AddTransition(observation, Action{}, 0.0f, 0, 1);
  EXPECT_EQ(builder.frames(), kMaxChunkFrames);

  const DrivingShape large{64, 50};
  ChunkBuilder large_builder(large, FloatCoding::kFloat32);
  const Observation noise = NoiseObservation(large, random);
  while (!large_builder.full()) large_builder.AddTransition(noise, Action{}, 0.0f, 0, 1);
  EXPECT_LT(large_builder.frames(), kMaxChunkFrames);
  const auto bytes = large_builder.Finish({1, 1, 1});
  EXPECT_LE(bytes.size(), kMaxChunkBytes);
  EXPECT_TRUE(ChunkView::Parse(bytes));
}

TEST(Chunk, EveryBitFlipIsDetected) {
  std::vector<std::byte> bytes = SmallChunk();
  for (size_t bit = 0; bit < bytes.size() * 8; ++bit) {
    bytes[bit / 8] ^= static_cast<std::byte>(1u << (bit % 8));
    EXPECT_NE(ErrorOf(bytes), "") << bit;
    bytes[bit / 8] ^= static_cast<std::byte>(1u << (bit % 8));
  }
  EXPECT_EQ(ErrorOf(bytes), "");
}

TEST(Chunk, EveryTruncationAndAnyExtraByteIsDetected) {
  std::vector<std::byte> bytes = SmallChunk();
  for (size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_NE(ErrorOf({bytes.begin(), bytes.begin() + static_cast<ptrdiff_t>(length)}), "") << length;
  }
  bytes.push_back(std::byte{0});
  EXPECT_NE(ErrorOf(bytes), "");
}

TEST(Chunk, WellSummedNonsenseIsRefusedWithItsReason) {
  using testing::HasSubstr;
  const std::vector<std::byte> good = SmallChunk();
  EXPECT_THAT(ErrorOf(Forged(good, 4, uint16_t{99})), HasSubstr("version 99"));
  EXPECT_THAT(ErrorOf(Forged(good, kFrames, uint32_t{0})), HasSubstr("0 frames"));
  EXPECT_THAT(ErrorOf(Forged(good, kFrames, uint32_t{65})), HasSubstr("65 frames"));
  EXPECT_THAT(ErrorOf(Forged(good, kFrames, uint32_t{1})), HasSubstr("its header says"));
  EXPECT_THAT(ErrorOf(Forged(good, kSequence, uint64_t{0})), HasSubstr("sequence 0"));
  EXPECT_THAT(ErrorOf(Forged(good, kSequence, kMaxSequence + 1)), HasSubstr("sequence 281474976710657"));
  EXPECT_THAT(ErrorOf(Forged(good, kSequence, ~uint64_t{0})), HasSubstr("sequence"));
  EXPECT_EQ(ErrorOf(Forged(good, kSequence, kMaxSequence)), "");
  EXPECT_THAT(ErrorOf(Forged(good, kActions, NAN)), HasSubstr("not finite"));
  EXPECT_THAT(ErrorOf(Forged(good, 6, uint16_t{3})), HasSubstr("its header says"));
  EXPECT_THAT(ErrorOf(Forged(good, 6, uint16_t{1025})), HasSubstr("at most 1024"));
  EXPECT_EQ(ErrorOf(Forged(good, 6, uint16_t{0})), "") << "as before decisions were counted";
  EXPECT_THAT(ErrorOf(Forged(good, kRewards + 4, INFINITY)),
              HasSubstr("frame 1 has a decision or a reward that is not finite"));
  EXPECT_THAT(ErrorOf(Forged(good, kOffsets, uint32_t{1})), HasSubstr("offsets"));
  EXPECT_THAT(ErrorOf(Forged(good, kOffsets + 4, uint32_t{0xfffffff0})), HasSubstr("no payload"));
  EXPECT_THAT(ErrorOf(Forged(good, kOffsets + 4, uint32_t{0})), HasSubstr("frame 0 has no payload"));
}

TEST(Chunk, FlagsThatNoEpisodeHasAreRefused) {
  const std::vector<std::byte> good = SmallChunk();
  const auto accepts = [&](uint8_t first, uint8_t second) {
    return ErrorOf(Forged(good, kFlags, std::array<uint8_t, 2>{first, second})).empty();
  };
  EXPECT_TRUE(accepts(kHasDecision, kHasDecision));
  EXPECT_TRUE(accepts(kHasDecision, kHasDecision | kTerminated));
  EXPECT_TRUE(accepts(kHasDecision, kHasDecision | kTruncated));
  EXPECT_TRUE(accepts(kHasDecision | kTruncated, 0));
  EXPECT_FALSE(accepts(kHasDecision | kTerminated, kHasDecision));
  EXPECT_FALSE(accepts(kHasDecision | kTruncated, kHasDecision));
  EXPECT_FALSE(accepts(kHasDecision, 0));
  EXPECT_FALSE(accepts(0, kHasDecision));
  EXPECT_FALSE(accepts(kHasDecision, kHasDecision | kTerminated | kTruncated));
  EXPECT_FALSE(accepts(kHasDecision, kTerminated));
  EXPECT_TRUE(accepts(kHasDecision, kHasDecision | kTerminated | kSuccess));
  EXPECT_FALSE(accepts(kHasDecision, kHasDecision | kSuccess));
  EXPECT_FALSE(accepts(kHasDecision, kHasDecision | kTruncated | kSuccess));
  EXPECT_FALSE(accepts(kHasDecision, kHasDecision | 16));
}

TEST(Chunk, SchemaFollowsTheObservation) {
  EXPECT_EQ(SchemaHash(DrivingShape{6, 5}), SchemaHash(DrivingShape{6, 5}));
  EXPECT_NE(SchemaHash(DrivingShape{6, 5}), SchemaHash(DrivingShape{7, 5}));
  EXPECT_NE(SchemaHash(DrivingShape{6, 5}), SchemaHash(DrivingShape{6, 4}));
}

}  // namespace
}  // namespace dadrl
