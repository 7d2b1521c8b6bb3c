#include "proto/sample_batch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "common/io/checksum.h"
#include "tests/proto/synthetic_experience.h"

namespace dadrl {
namespace {

const ObservationSpec kSpec;
constexpr double kGamma = 0.9;

// Two items, one bootstrapped after three steps, one terminated after one.
struct Fixture {
  Random random{1};
  FrameCodec codec{kSpec, FloatCoding::kFloat32};
  Observation first = SyntheticObservation(kSpec, random);
  Observation next = SyntheticObservation(kSpec, random);
  std::vector<std::byte> first_payload;
  std::vector<std::byte> next_payload;
  std::vector<float> rewards = {1.0f, 2.0f, 4.0f};
  std::vector<SampledItem> items{2};

  Fixture() {
    codec.Encode(first, first_payload);
    codec.Encode(next, next_payload);
    items[0] = {.key = 11,
                .probability = 0.5f,
                .importance_weight = 0.75f,
                .policy_version = 7,
                .action = {0.1f, 0.2f},
                .terminated = false,
                .rewards = rewards,
                .first = first_payload,
                .next = next_payload};
    items[1] = items[0];
    items[1].key = 12;
    items[1].terminated = true;
    items[1].rewards = std::span(rewards).first(1);
    items[1].next = {};
  }

  std::vector<std::byte> Encode() const { return EncodeSampleBatch(items, SchemaHash(kSpec)); }
  Status Decode(const std::vector<std::byte>& bytes, TransitionBatch& batch) {
    return DecodeSampleBatch(bytes, SchemaHash(kSpec), kGamma, ExperienceBounds::From(Config{}), codec,
                             batch);
  }
};

TEST(SampleBatch, DecodesToTransitionsWithSummedRewards) {
  Fixture fixture;
  TransitionBatch batch(kSpec, 2);
  std::fill(batch.next_observation.ego.begin(), batch.next_observation.ego.end(), 5.0f);
  ASSERT_TRUE(fixture.Decode(fixture.Encode(), batch));
  EXPECT_FLOAT_EQ(batch.reward[0], 1.0f + 0.9f * 2.0f + 0.81f * 4.0f);
  EXPECT_FLOAT_EQ(batch.discount[0], 0.729f);
  EXPECT_FLOAT_EQ(batch.reward[1], 1.0f);
  EXPECT_EQ(batch.discount[1], 0.0f);
  EXPECT_EQ(batch.weight[0], 0.75f);
  EXPECT_EQ(batch.key, (std::vector<uint64_t>{11, 12}));
  EXPECT_EQ(batch.policy_version[0], 7u);
  EXPECT_EQ(batch.action[3], 0.2f);
  const auto ego = static_cast<ptrdiff_t>(kSpec.ego_floats());
  EXPECT_TRUE(std::equal(fixture.first.ego.begin(), fixture.first.ego.end(), batch.observation.ego.begin()));
  EXPECT_TRUE(
      std::equal(fixture.next.ego.begin(), fixture.next.ego.end(), batch.next_observation.ego.begin()));
  EXPECT_TRUE(std::equal(fixture.next.context.begin(), fixture.next.context.end(),
                         batch.next_observation.context.begin()));
  EXPECT_TRUE(std::all_of(batch.next_observation.ego.begin() + ego, batch.next_observation.ego.end(),
                          [](float value) { return value == 0.0f; }));
}

TEST(SampleBatch, RefusesAnotherSchemaAndAnotherSize) {
  Fixture fixture;
  TransitionBatch right(kSpec, 2);
  TransitionBatch wrong(kSpec, 3);
  EXPECT_FALSE(fixture.Decode(fixture.Encode(), wrong));
  EXPECT_FALSE(fixture.Decode(EncodeSampleBatch(fixture.items, 1), right));
}

TEST(SampleBatch, EveryTruncationAndManyBitFlipsAreDetected) {
  Fixture fixture;
  TransitionBatch batch(kSpec, 2);
  std::vector<std::byte> bytes = fixture.Encode();
  for (size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_FALSE(fixture.Decode({bytes.begin(), bytes.begin() + static_cast<ptrdiff_t>(length)}, batch));
  }
  for (size_t bit = 0; bit < bytes.size() * 8; bit += 3) {
    bytes[bit / 8] ^= static_cast<std::byte>(1u << (bit % 8));
    EXPECT_FALSE(fixture.Decode(bytes, batch)) << bit;
    bytes[bit / 8] ^= static_cast<std::byte>(1u << (bit % 8));
  }
  EXPECT_TRUE(fixture.Decode(bytes, batch));
}

TEST(SampleBatch, WellSummedWrongLengthsAreRefused) {
  Fixture fixture;
  TransitionBatch batch(kSpec, 2);
  const std::vector<std::byte> good = fixture.Encode();
  constexpr size_t kEntries = 24;
  constexpr size_t kRewards = kEntries + 2 * 40;
  const auto refuses = [&](size_t at, auto value) {
    std::vector<std::byte> bytes = good;
    std::memcpy(&bytes[at], &value, sizeof(value));
    const uint64_t checksum = Xxh3(std::span(bytes).first(bytes.size() - 8));
    std::memcpy(&bytes[bytes.size() - 8], &checksum, 8);
    return !fixture.Decode(bytes, batch);
  };
  EXPECT_TRUE(refuses(kEntries + 28, uint16_t{0}));           // steps
  EXPECT_TRUE(refuses(kEntries + 28, uint16_t{33}));          // steps
  EXPECT_TRUE(refuses(kEntries + 28, uint16_t{4}));           // steps: shifts everything behind
  EXPECT_TRUE(refuses(kEntries + 30, uint16_t{2}));           // terminated
  EXPECT_TRUE(refuses(kEntries + 30, uint16_t{1}));           // terminated, but with a next frame
  EXPECT_TRUE(refuses(kEntries + 32, uint32_t{0}));           // first frame missing
  EXPECT_TRUE(refuses(kEntries + 32, uint32_t{0xffffffff}));  // longer than the message
  EXPECT_TRUE(refuses(kEntries + 40 + 36, uint32_t{1}));      // next frame of a terminated item
  EXPECT_TRUE(refuses(kEntries + 8, -0.5f));                  // probability
  EXPECT_TRUE(refuses(kEntries + 12, 1.5f));                  // importance weight
  EXPECT_TRUE(refuses(kEntries + 20, 1.001f));                // action
  EXPECT_TRUE(refuses(kEntries + 24, std::nanf("")));         // action
  for (const float reward : {1e30f, 3e38f, -6.0f, std::nanf(""), std::numeric_limits<float>::infinity()}) {
    EXPECT_TRUE(refuses(kRewards, reward)) << reward;
    EXPECT_TRUE(refuses(kRewards + 3 * 4, reward)) << reward << ", of the last";
  }
  EXPECT_FALSE(refuses(kRewards, -5.5f));
}

TEST(SampleBatch, AFeatureBeyondWhatSensingClampsToIsRefused) {
  Fixture fixture;
  TransitionBatch batch(kSpec, 2);
  for (const float feature : {5.001f, -65504.0f, 3e38f}) {
    Observation impossible = fixture.first;
    impossible.vehicles[9] = feature;
    std::vector<std::byte> payload;
    fixture.codec.Encode(impossible, payload);
    fixture.items[1].first = payload;
    const Status decoded = fixture.Decode(fixture.Encode(), batch);
    ASSERT_FALSE(decoded) << feature;
    EXPECT_NE(decoded.error().message.find("beyond 5"), std::string::npos) << decoded.error().message;
  }
}

}  // namespace
}  // namespace dadrl
