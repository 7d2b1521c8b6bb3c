#include "proto/trajectory_codec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "common/io/checksum.h"
#include "tests/driving_columns.h"
#include "tests/proto/synthetic_experience.h"

namespace dadrl {
namespace {

const DrivingShape kSpec;

// Two trajectories of up to three steps, the second terminated after one.
struct Fixture {
  explicit Fixture(bool all_observations = false) : shape{2, 3, all_observations} {
    for (Observation& observation : observations) {
      codec.Encode(observation, payloads.emplace_back());
    }
    for (uint32_t i = 0; i < 3; ++i) {
      steps.push_back({7 + i, static_cast<float>(1 << i), std::as_bytes(std::span(actions[i]))});
    }
    sent = all_observations ? std::vector<std::span<const std::byte>>(payloads.begin(), payloads.end())
                            : std::vector<std::span<const std::byte>>{payloads[0], payloads[3]};
    trajectories[0] = {
        .key = 11, .probability = 0.5f, .importance_weight = 0.75f, .steps = steps, .payloads = sent};
    trajectories[1] = trajectories[0];
    trajectories[1].key = 12;
    trajectories[1].terminated = true;
    trajectories[1].steps = std::span(steps).first(1);
    trajectories[1].payloads = std::span(sent).first(1);
  }

  std::vector<std::byte> Encode(uint64_t schema = SchemaHash(kSpec)) const {
    return EncodeTrajectories(trajectories, shape, schema);
  }
  Status Decode(const std::vector<std::byte>& bytes, TrajectoryBatch& batch) {
    return decoder.Decode(bytes, batch);
  }

  TrajectoryShape shape;
  Random random{1};
  PayloadCodec codec{kSpec, FloatCoding::kFloat32};
  std::array<Observation, 4> observations{
      SyntheticObservation(kSpec, random), SyntheticObservation(kSpec, random),
      SyntheticObservation(kSpec, random), SyntheticObservation(kSpec, random)};
  std::vector<std::vector<std::byte>> payloads;
  std::vector<std::span<const std::byte>> sent;
  std::array<Action, 3> actions{{{0.1f, 0.2f}, {0.3f, 0.4f}, {0.5f, 0.6f}}};
  std::vector<SampledStep> steps;
  std::vector<SampledTrajectory> trajectories{2};
  TrajectoryDecoder decoder{kSpec, ExperienceBounds::From(Config{})};
};

bool Same(ColumnRows rows, int row, const Observation& observation) {
  const auto part = [&](auto all) {
    return all.subspan(static_cast<size_t>(row) * all.size() / static_cast<size_t>(rows.rows()),
                       all.size() / static_cast<size_t>(rows.rows()));
  };
  bool same = true;
  for (size_t i = 0; i < observation.columns(); ++i) {
    same = same && std::ranges::equal(part(rows.floats(i)), observation.floats(i)) &&
           std::ranges::equal(part(rows.bits(i)), observation.bits(i));
  }
  return same;
}

TEST(TrajectoryCodec, TheEndsComeBackWithAllStepsBetween) {
  Fixture fixture;
  TrajectoryBatch batch(kSpec, fixture.shape);
  const Status decoded = fixture.Decode(fixture.Encode(), batch);
  ASSERT_TRUE(decoded) << decoded.error().message;
  EXPECT_EQ(batch.steps, (std::vector{3, 1}));
  EXPECT_EQ(batch.terminated, (std::vector<uint8_t>{0, 1}));
  EXPECT_EQ(batch.truncated, (std::vector<uint8_t>{0, 0}));
  EXPECT_EQ(batch.rewards, (std::vector{1.0f, 1.0f, 2.0f, 0.0f, 4.0f, 0.0f}));
  EXPECT_EQ(batch.policy_versions, (std::vector<uint32_t>{7, 7, 8, 0, 9, 0}));
  EXPECT_THAT(batch.DecisionsAt(0, 0), testing::ElementsAre(0.1f, 0.2f, 0.1f, 0.2f));
  EXPECT_THAT(batch.DecisionsAt(0, 2), testing::ElementsAre(0.5f, 0.6f, 0.0f, 0.0f));
  EXPECT_EQ(batch.weights[0], 0.75f);
  EXPECT_EQ(batch.keys, (std::vector<uint64_t>{11, 12}));
  EXPECT_TRUE(Same(batch.ObservationsAt(0), 0, fixture.observations[0]));
  EXPECT_TRUE(Same(batch.ObservationsAt(0), 1, fixture.observations[0]));
  EXPECT_TRUE(Same(batch.ObservationsAt(1), 0, fixture.observations[3]));
  EXPECT_TRUE(Same(batch.ObservationsAt(1), 1, Observation(kSpec))) << "nothing follows a termination";
}

TEST(TrajectoryCodec, AllObservationsComeBackStepByStep) {
  Fixture fixture(true);
  TrajectoryBatch batch(kSpec, fixture.shape);
  ASSERT_TRUE(fixture.Decode(fixture.Encode(), batch));
  for (int t = 0; t < 4; ++t) {
    EXPECT_TRUE(Same(batch.ObservationsAt(t), 0, fixture.observations[static_cast<size_t>(t)])) << t;
    EXPECT_TRUE(Same(batch.ObservationsAt(t), 1, t == 0 ? fixture.observations[0] : Observation(kSpec))) << t;
  }
}

TEST(TrajectoryCodec, MemoryOfAnEarlierBatchLeavesNothingBehind) {
  Fixture fixture;
  const std::vector<std::byte> bytes = fixture.Encode();
  EXPECT_EQ(bytes.size(), TrajectoriesBytes(fixture.trajectories));
  EXPECT_EQ(EncodeTrajectories(fixture.trajectories, fixture.shape, SchemaHash(kSpec),
                               std::vector<std::byte>(100000, std::byte{7})),
            bytes);
}

TEST(TrajectoryCodec, RefusesAnotherSchemaAndAnotherShape) {
  Fixture fixture;
  TrajectoryBatch right(kSpec, fixture.shape);
  EXPECT_FALSE(fixture.Decode(fixture.Encode(1), right));
  for (const TrajectoryShape& other :
       {TrajectoryShape{3, 3}, TrajectoryShape{2, 4}, TrajectoryShape{2, 3, true}}) {
    TrajectoryBatch wrong(kSpec, other);
    EXPECT_FALSE(fixture.Decode(fixture.Encode(), wrong));
  }
}

TEST(TrajectoryCodec, EveryTruncationAndManyBitFlipsAreDetected) {
  Fixture fixture;
  TrajectoryBatch batch(kSpec, fixture.shape);
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

TEST(TrajectoryCodec, WellSummedNonsenseIsRefused) {
  Fixture fixture;
  TrajectoryBatch batch(kSpec, fixture.shape);
  const std::vector<std::byte> good = fixture.Encode();
  constexpr size_t kEntries = 40;
  constexpr size_t kSecond = kEntries + 20;
  constexpr size_t kSteps = kEntries + 2 * 20;  // version, reward, two of an action
  constexpr size_t kLengths = kSteps + 4 * 16;
  const auto refuses = [&](size_t at, auto value) {
    std::vector<std::byte> bytes = good;
    std::memcpy(&bytes[at], &value, sizeof(value));
    const uint64_t checksum = Xxh3(std::span(bytes).first(bytes.size() - 8));
    std::memcpy(&bytes[bytes.size() - 8], &checksum, 8);
    return !fixture.Decode(bytes, batch);
  };
  EXPECT_TRUE(refuses(kEntries + 16, uint16_t{0}));      // steps
  EXPECT_TRUE(refuses(kEntries + 16, uint16_t{4}));      // more than asked for
  EXPECT_TRUE(refuses(kEntries + 16, uint16_t{2}));      // fewer, without an end
  EXPECT_TRUE(refuses(kEntries + 18, uint16_t{3}));      // an end that is none
  EXPECT_TRUE(refuses(kEntries + 18, uint16_t{1}));      // terminated, but something follows
  EXPECT_TRUE(refuses(kSecond + 18, uint16_t{2}));       // not terminated, and nothing follows
  EXPECT_TRUE(refuses(kEntries + 8, -0.5f));             // probability
  EXPECT_TRUE(refuses(kEntries + 12, 1.5f));             // importance weight
  EXPECT_TRUE(refuses(kSteps + 8, 1.001f));              // action
  EXPECT_TRUE(refuses(kSteps + 12, std::nanf("")));      // action
  EXPECT_TRUE(refuses(kLengths, uint32_t{0}));           // first observation missing
  EXPECT_TRUE(refuses(kLengths, uint32_t{0xffffffff}));  // longer than the message
  for (const float reward : {1e30f, 3e38f, -6.0f, std::nanf(""), std::numeric_limits<float>::infinity()}) {
    EXPECT_TRUE(refuses(kSteps + 4, reward)) << reward;
    EXPECT_TRUE(refuses(kSteps + 3 * 16 + 4, reward)) << reward << ", of the last";
  }
  EXPECT_FALSE(refuses(kSteps + 4, -5.5f));
}

TEST(TrajectoryCodec, AFeatureBeyondWhatSensingClampsToIsRefused) {
  Fixture fixture;
  TrajectoryBatch batch(kSpec, fixture.shape);
  for (const float feature : {5.001f, -65504.0f, 3e38f}) {
    Observation impossible = fixture.observations[0];
    VehiclesOf(impossible)[9] = feature;
    fixture.payloads[0].clear();
    fixture.codec.Encode(impossible, fixture.payloads[0]);
    fixture.sent[0] = fixture.payloads[0];
    const Status decoded = fixture.Decode(fixture.Encode(), batch);
    ASSERT_FALSE(decoded) << feature;
    EXPECT_NE(decoded.error().message.find("beyond 5"), std::string::npos) << decoded.error().message;
  }
}

}  // namespace
}  // namespace dadrl
