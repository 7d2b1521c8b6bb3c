// Fixed-length sequences from the table to what a learner decodes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>

#include <cstring>
#include <map>
#include <set>
#include <sstream>

#include "common/io/checksum.h"
#include "common/util/log.h"
#include "proto/trajectory_codec.h"
#include "replay/table.h"
#include "tests/driving_columns.h"
#include "tests/replay/test_chunks.h"

namespace dadrl {
namespace {

constexpr int kLength = 5;

struct Episode {
  uint32_t frames = 0;
  uint8_t end = 0;  // 0: still open
};

class SequencesTest : public testing::Test {
 protected:
  std::unique_ptr<ReplayTable> Open(int period, int max_times_sampled) {
    TableOptions options{.directory = {}, .spec = kTestSpec, .replay = {}, .n_step = 1};
    options.replay.min_size = 1;
    options.replay.samples_per_insert = 0.0;
    options.replay.sequence_length = kLength;
    options.replay.sequence_period = period;
    options.replay.max_times_sampled = max_times_sampled;
    return ReplayTable::Open(options, clock_).value();
  }
  // In chunks of random sizes; the final frame of a truncated one sometimes in a chunk of its own.
  void Store(ReplayTable& table, uint64_t number, const Episode& episode, Random& random) {
    for (uint32_t frame = 0; frame < episode.frames;) {
      const auto left = static_cast<int>(episode.frames - frame);
      TestChunk chunk{.identity = {1, 1, ++sequence_},
                      .episode = number,
                      .first_frame = frame,
                      .frames = std::min(left, static_cast<int>(1 + random.Below(4))),
                      .policy_version = static_cast<uint32_t>(number)};
      frame += static_cast<uint32_t>(chunk.frames);
      const bool last = frame == episode.frames;
      if (last) chunk.end = episode.end;
      const bool final_apart = random.Uniform() < 0.5;
      chunk.final_frame = last && episode.end == kTruncated && !final_apart;
      ASSERT_EQ(table.Insert(Build(chunk)), ReplayTable::Insertion::kStored);
      if (last && episode.end == kTruncated && final_apart) {
        ASSERT_EQ(table.Insert(Build({.identity = {1, 1, ++sequence_},
                                      .episode = number,
                                      .first_frame = frame,
                                      .frames = 0,
                                      .final_frame = true})),
                  ReplayTable::Insertion::kStored);
      }
    }
  }

  SystemClock clock_;
  uint64_t sequence_ = 0;
};

TEST_F(SequencesTest, AreExactlyTheStretchesOfTheEpisodesAndEndWithThem) {
  for (const int period : {1, 2, 5}) {
    Random random(static_cast<uint64_t>(period));
    const auto table = Open(period, 1);
    std::map<uint64_t, Episode> episodes;
    std::set<float> starts;
    for (uint64_t number = 1; number <= 60; ++number) {
      const uint8_t end = number == 60 ? 0 : random.Uniform() < 0.5 ? kTerminated : kTruncated;
      const Episode episode{static_cast<uint32_t>(1 + random.Below(17)), end};
      episodes[number] = episode;
      Store(*table, number, episode, random);
      for (uint32_t frame = 0; frame < episode.frames; frame += static_cast<uint32_t>(period)) {
        // Of an open episode those with a whole sequence and the observation behind it.
        if (end != 0 || frame + kLength < episode.frames) starts.insert(TestReward(1, number, frame));
      }
    }
    const size_t count = starts.size();
    ASSERT_EQ(table->stats().items, count);
    const TrajectoryShape shape{static_cast<int>(count), kLength, true};
    const auto sampled = table->Sample(shape, 0).value();
    const auto bytes = EncodeTrajectories(sampled.trajectories, shape, table->schema());
    TrajectoryBatch batch(kTestSpec, shape);
    const Status decoded = TrajectoryDecoder(kTestSpec, kTestBounds).Decode(bytes, batch);
    ASSERT_TRUE(decoded) << decoded.error().message;
    for (size_t i = 0; i < count; ++i) {
      const float first = batch.rewards[i];
      ASSERT_EQ(starts.erase(first), 1u) << "each start once";
      const auto value = static_cast<uint64_t>(first / kTestScale) - 10000;
      const uint64_t number = value / 100;
      const auto start = static_cast<uint32_t>(value % 100);
      const Episode& episode = episodes.at(number);
      const auto steps = static_cast<int>(std::min<uint32_t>(kLength, episode.frames - start));
      const bool at_end = start + static_cast<uint32_t>(steps) == episode.frames;
      ASSERT_EQ(batch.steps[i], steps);
      ASSERT_EQ(batch.terminated[i], at_end && episode.end == kTerminated);
      ASSERT_EQ(batch.truncated[i], at_end && episode.end == kTruncated);
      for (int t = 0; t <= kLength; ++t) {
        const size_t row = static_cast<size_t>(t) * batch.steps.size() + i;
        const bool frame = t < steps || (t == steps && !batch.terminated[i]);
        const float wanted = frame ? TestReward(1, number, start + static_cast<uint32_t>(t)) : 0.0f;
        ASSERT_EQ(EgoOf(batch.observations)[row * 20 + 1], wanted);
        if (t == kLength) continue;
        const size_t step = row;
        ASSERT_EQ(batch.rewards[step], t < steps ? wanted : 0.0f);
        ASSERT_EQ(batch.decisions[0][2 * step], t < steps ? 0.5f : 0.0f);
        ASSERT_EQ(batch.policy_versions[step], t < steps ? number : 0u);
      }
    }
    EXPECT_TRUE(starts.empty());
  }
}

TEST_F(SequencesTest, SlicesCanBeSampledBesideThemAndLongerOnesAreRefused) {
  Random random(1);
  const auto table = Open(1, 0);
  Store(*table, 1, {12, kTerminated}, random);
  EXPECT_TRUE(table->Sample({4, 1}, 0));
  EXPECT_TRUE(table->Sample({4, 3, true}, 0));
  const auto refused = table->Sample({4, kLength + 1, true}, 0);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, testing::HasSubstr("replay.sequence_length 5"));
  EXPECT_EQ(table->stats().sampled, 4u + 4u * 3u);
}

TEST_F(SequencesTest, AReplayTooSmallForOneSaysSoOnce) {
  std::ostringstream log;
  const auto sink = std::make_shared<spdlog::sinks::ostream_sink_st>(log);
  spdlog::default_logger()->sinks().push_back(sink);
  MemoryFolder folder;
  TableOptions options{.directory = folder.path(), .spec = kTestSpec, .replay = {}, .n_step = 1};
  options.replay.segment_bytes = 4096;
  options.replay.max_disk_bytes = 16384;
  options.replay.sequence_length = 256;
  const auto table = ReplayTable::Open(options, clock_).value();
  for (uint32_t chunk = 0; chunk < 400; ++chunk) {
    ASSERT_EQ(table->Insert(Build({.identity = {1, 1, chunk + 1}, .first_frame = 4 * chunk})),
              ReplayTable::Insertion::kStored);
  }
  spdlog::default_logger()->sinks().pop_back();
  EXPECT_EQ(table->stats().items, 0u);
  EXPECT_THAT(log.str(), testing::HasSubstr("each waits for 256 decisions of its episode to follow"));
  EXPECT_EQ(log.str().find("max_disk_bytes"), log.str().rfind("max_disk_bytes"));
}

TEST_F(SequencesTest, DamagedBytesAreRefusedWhereverTheyAreDamaged) {
  Random random(2);
  const auto table = Open(1, 0);
  for (uint64_t number = 1; number <= 5; ++number) Store(*table, number, {7, kTruncated}, random);
  const TrajectoryShape shape{3, kLength, true};
  const auto sampled = table->Sample(shape, 0).value();
  const auto sound = EncodeTrajectories(sampled.trajectories, shape, table->schema());
  TrajectoryBatch batch(kTestSpec, shape);
  TrajectoryDecoder decoder(kTestSpec, kTestBounds);
  for (size_t cut = 0; cut < sound.size(); ++cut) {
    ASSERT_FALSE(decoder.Decode(std::span(sound).first(cut), batch)) << cut;
  }
  // With a checksum that fits: nothing is read outside, what is accepted has the shape that was asked for.
  for (int round = 0; round < 20000; ++round) {
    auto bytes = sound;
    bytes[random.Below(bytes.size() - 8)] = static_cast<std::byte>(random.Next());
    const uint64_t checksum = Xxh3(std::span(bytes).first(bytes.size() - 8));
    std::memcpy(&bytes[bytes.size() - 8], &checksum, 8);
    if (!decoder.Decode(bytes, batch)) continue;
    for (const int steps : batch.steps) {
      ASSERT_GE(steps, 1);
      ASSERT_LE(steps, kLength);
    }
  }
  TrajectoryBatch other(kTestSpec, {3, kLength + 1, true});
  EXPECT_FALSE(decoder.Decode(sound, other));
}

}  // namespace
}  // namespace dadrl
