#include "replay/table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <memory>
#include <set>
#include <thread>

#include "tests/common/util/captured_log.h"
#include "tests/replay/test_chunks.h"

namespace dadrl {
namespace {

using Insertion = ReplayTable::Insertion;

TableOptions Options(const std::filesystem::path& directory = {}) {
  TableOptions options{.directory = directory, .spec = kTestSpec, .replay = {}, .n_step = 1};
  options.replay.min_size = 1;
  options.replay.samples_per_insert = 0.0;
  options.replay.max_disk_bytes = 1 << 20;
  options.replay.segment_bytes = 1 << 16;
  return options;
}

std::vector<std::byte> EpisodeChunk(uint64_t sequence, int frames = 10) {
  return Build({.identity = {1, 1, sequence}, .episode = sequence, .frames = frames, .end = kTerminated});
}

TEST(ReplayTable, StoresEachChunkOnceAndSamplesIt) {
  SystemClock clock;
  auto table = ReplayTable::Open(Options(), clock).value();
  EXPECT_EQ(table->Insert(EpisodeChunk(1)), Insertion::kStored);
  EXPECT_EQ(table->Insert(EpisodeChunk(1)), Insertion::kDuplicate);
  EXPECT_EQ(table->Insert(EpisodeChunk(3), 1), Insertion::kEarly);
  EXPECT_EQ(table->Insert(EpisodeChunk(2), 1), Insertion::kStored);
  EXPECT_EQ(table->Insert(EpisodeChunk(3), 1), Insertion::kStored);
  const ReplayTable::Stats stats = table->stats();
  EXPECT_EQ(stats.inserted_frames, 30u);
  EXPECT_EQ(stats.items, 30u);
  EXPECT_EQ(stats.duplicate_chunks, 1u);
  EXPECT_EQ(stats.lost_chunks, 0u);
  EXPECT_EQ(table->Stored(1, 1), 3u);
  const auto batch = table->Sample({64, 1}, 0);
  ASSERT_TRUE(batch);
  ASSERT_EQ(batch->trajectories.size(), 64u);
  for (const SampledTrajectory& item : batch->trajectories)
    EXPECT_EQ(Decode(item.payloads.front()), item.steps[0].reward);
  EXPECT_EQ(table->stats().sampled, 64u);
}

TEST(ReplayTable, RefusesRewardsThatTheTaskCannotGiveAndTheirActorGoesOn) {
  SystemClock clock;
  const CapturedLog log;
  auto table = ReplayTable::Open(Options(), clock).value();
  uint64_t sequence = 0;
  const auto insert = [&](float reward) {
    ++sequence;
    return table->Insert(
        Build({.identity = {1, 1, sequence}, .episode = 1, .end = kTerminated, .last_reward = reward}),
        sequence);
  };
  for (const float reward : {1e30f, 3e38f, -3e38f, -5.6f}) EXPECT_EQ(insert(reward), Insertion::kRejected);
  EXPECT_EQ(insert(-5.5f), Insertion::kStored);
  EXPECT_EQ(table->stats().rejected_chunks[static_cast<size_t>(ChunkFault::kContents)], 4u);
  EXPECT_EQ(table->stats().items, 4u);
  EXPECT_EQ(table->Stored(1, 1), 5u);
  EXPECT_THAT(log.text(), testing::HasSubstr("actor 1, episode 1, frame 3: reward 1e+30 is beyond 5.56"));
  EXPECT_EQ(log.text().find("refused a chunk"), log.text().rfind("refused a chunk")) << "said once";
}

TEST(ReplayTable, RefusesDecisionsBeyondTheBoundsOfTheirColumns) {
  SystemClock clock;
  const CapturedLog log;
  const MemoryFolder folder;
  uint64_t sequence = 0;
  const auto chunk = [&](float first) {
    ChunkBuilder builder(kTestSpec, FloatCoding::kFloat32);
    builder.Begin(1, 0);
    builder.AddTransition(Observation(kTestSpec), Action{first, 0.0f}, 0.0f, kTerminated, 1);
    return builder.Finish({1, 1, ++sequence});
  };
  {
    auto table = ReplayTable::Open(Options(folder.path()), clock).value();
    EXPECT_EQ(table->Insert(chunk(1.5f), 1), Insertion::kRejected);
    EXPECT_EQ(table->Insert(chunk(1.0f), 2), Insertion::kStored);
    EXPECT_EQ(table->stats().rejected_chunks[static_cast<size_t>(ChunkFault::kContents)], 1u);
    EXPECT_THAT(log.text(), testing::HasSubstr("decision (1.5, 0) is beyond what its columns allow"));
  }
  // The same found on disk, stored by somebody for whom it was possible.
  StepSpec wide = kTestSpec;
  wide.decision[0].bound = 2.0f;
  TableOptions options = Options(folder.path());
  options.spec = wide;
  EXPECT_EQ(ReplayTable::Open(options, clock).value()->Insert(chunk(1.5f), 3), Insertion::kStored);
  EXPECT_EQ(ReplayTable::Open(Options(folder.path()), clock).value()->stats().frames_held, 1u);
}

TEST(ReplayTable, RefusesPrioritiesThatNoErrorHas) {
  SystemClock clock;
  TableOptions options = Options();
  options.replay.sampler = SamplerKind::kHighestPriority;
  options.replay.max_times_sampled = 1000;
  auto table = ReplayTable::Open(options, clock).value();
  ASSERT_EQ(table->Insert(EpisodeChunk(1)), Insertion::kStored);
  const uint64_t first = table->Sample({1, 1}, 0).value().trajectories[0].key;
  table->UpdatePriorities({{first + 5}}, {{3.0f}});
  for (const float priority : {NAN, -1.0f, INFINITY, 3e38f}) {
    table->UpdatePriorities({{first}}, {{priority}});
  }
  EXPECT_EQ(table->stats().refused_priorities, 4u);
  EXPECT_EQ(table->Sample({1, 1}, 0).value().trajectories[0].key, first + 5);
}

TEST(ReplayTable, GoesOnBehindChunksThatNobodyHasAnyMore) {
  SystemClock clock;
  auto table = ReplayTable::Open(Options(), clock).value();
  EXPECT_EQ(table->Insert(EpisodeChunk(1), 1), Insertion::kStored);
  EXPECT_EQ(table->Insert(EpisodeChunk(6), 5), Insertion::kEarly);
  EXPECT_EQ(table->Insert(EpisodeChunk(5), 5), Insertion::kStored);
  EXPECT_EQ(table->stats().lost_chunks, 3u);
}

TEST(ReplayTable, RefusesGarbageForeignSchemasAndWhatFailsVerification) {
  SystemClock clock;
  TableOptions options = Options();
  options.verify = [](const ChunkView& chunk) -> Status {
    if (chunk.header().episode == 2) return Fail(ErrorCode::kCorrupt, "bad frame");
    return {};
  };
  auto table = ReplayTable::Open(options, clock).value();
  EXPECT_EQ(table->Insert(std::vector<std::byte>(100)), Insertion::kRejected);
  ChunkBuilder foreign(DrivingShape{.vehicles = 2, .history = 1}, FloatCoding::kFloat16);
  foreign.AddTransition(Observation(DrivingShape{.vehicles = 2, .history = 1}), Action{}, 0.0f, kTerminated,
                        1);
  ChunkRefusal refusal;
  EXPECT_EQ(table->Insert(foreign.Finish({9, 1, 1}), 1, &refusal), Insertion::kRejected);
  EXPECT_EQ(refusal.fault, ChunkFault::kSchema);
  EXPECT_EQ(table->Stored(9, 1), 1u) << "its actor goes on, if it has something better";
  EXPECT_EQ(table->Insert(EpisodeChunk(1), 1), Insertion::kStored);
  EXPECT_EQ(table->Insert(EpisodeChunk(2), 2), Insertion::kRejected);
  const auto rejected = [&](ChunkFault fault) {
    return table->stats().rejected_chunks[static_cast<size_t>(fault)];
  };
  EXPECT_EQ(rejected(ChunkFault::kGarbage), 1u);
  EXPECT_EQ(rejected(ChunkFault::kSchema), 1u);
  EXPECT_EQ(rejected(ChunkFault::kContents), 1u);
  // The bad chunk is done with: its actor goes on.
  EXPECT_EQ(table->Stored(1, 1), 2u);
  EXPECT_EQ(table->Insert(EpisodeChunk(3), 3), Insertion::kStored);
  EXPECT_EQ(table->stats().items, 20u);
}

TEST(ReplayTable, SamplingWaitsForTheMinimumSizeAndForInserts) {
  ManualClock clock;
  TableOptions options = Options();
  options.replay.min_size = 20;
  options.replay.samples_per_insert = 2.0;
  options.replay.samples_per_insert_band = 1.0;
  auto table = ReplayTable::Open(options, clock).value();
  ASSERT_TRUE(table->Insert(EpisodeChunk(1)));
  EXPECT_EQ(table->MaySample({8}), RateLimiter::Hold::kMinimumSize);
  ASSERT_TRUE(table->Insert(EpisodeChunk(2)));
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(table->Sample({8, 1}, 0));
  EXPECT_EQ(table->MaySample({8}), RateLimiter::Hold::kSamplesPerInsert);
  const auto refused = table->Sample({8, 1}, 0);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnavailable);
  EXPECT_TRUE(table->MayInsert());
  table->Reconfigure({.min_size = 1});
  EXPECT_TRUE(table->Sample({8, 1}, 0));
}

TEST(ReplayTable, ActorsAreNotHeldBackWhileABatchIsLargerThanWhatIsLeftToSample) {
  SystemClock clock;
  TableOptions options = Options();
  options.replay.min_size = 10;
  options.replay.max_times_sampled = 1;
  options.replay.min_samples_per_insert = 1.0;
  auto table = ReplayTable::Open(options, clock).value();
  constexpr size_t kBatch = 64;
  for (uint64_t sequence = 1; table->MaySample({kBatch}) != RateLimiter::Hold::kNone; ++sequence) {
    ASSERT_TRUE(table->MayInsert()) << "both sides wait, with " << table->stats().items << " items";
    ASSERT_EQ(table->Insert(EpisodeChunk(sequence)), Insertion::kStored);
  }
  EXPECT_FALSE(table->MayInsert()) << "now it is the learner's turn";
  EXPECT_TRUE(table->Sample({kBatch, 1}, 0));
}

TEST(ReplayTable, LongerSlicesThanItIndexesAreRefusedWithTheReason) {
  SystemClock clock;
  auto table = ReplayTable::Open(Options(), clock).value();
  ASSERT_TRUE(table->Insert(EpisodeChunk(1)));
  const auto batch = table->Sample({1, 2}, 0);
  ASSERT_FALSE(batch);
  EXPECT_EQ(batch.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(batch.error().message, testing::HasSubstr("algorithm.n_step"));
}

TEST(ReplayTable, TheSameSeedSamplesTheSameItems) {
  SystemClock clock;
  std::vector<std::vector<uint64_t>> keys(2);
  for (auto& run : keys) {
    auto table = ReplayTable::Open(Options(), clock).value();
    for (uint64_t sequence = 1; sequence <= 5; ++sequence) ASSERT_TRUE(table->Insert(EpisodeChunk(sequence)));
    const auto batch = table->Sample({50, 1}, 0);
    for (const SampledTrajectory& item : batch->trajectories) run.push_back(item.key);
  }
  EXPECT_EQ(keys[0], keys[1]);
}

TEST(ReplayTable, DiskStaysWithinItsBoundAndTheNewestStay) {
  SystemClock clock;
  MemoryFolder folder;
  TableOptions options = Options(folder.path());
  options.replay.max_disk_bytes = 100000;
  auto table = ReplayTable::Open(options, clock).value();
  constexpr uint64_t kChunks = 600;
  for (uint64_t sequence = 1; sequence <= kChunks; ++sequence) {
    ASSERT_EQ(table->Insert(EpisodeChunk(sequence)), Insertion::kStored);
    uint64_t on_disk = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
      if (entry.path().filename().string().starts_with("segment-")) on_disk += entry.file_size();
    }
    ASSERT_LE(on_disk, 100000u);
    ASSERT_EQ(on_disk, table->stats().disk_bytes);
  }
  const ReplayTable::Stats stats = table->stats();
  EXPECT_EQ(stats.inserted_frames, kChunks * 10);
  EXPECT_LT(stats.items, kChunks * 10);
  EXPECT_GT(stats.disk_bytes, 60000u);
  const auto batch = table->Sample({5000, 1}, 0).value();
  std::set<uint64_t> episodes;
  for (const SampledTrajectory& item : batch.trajectories) {
    episodes.insert(static_cast<uint64_t>((item.steps[0].reward / kTestScale - 10000.0f) / 100.0f));
  }
  EXPECT_EQ(*episodes.rbegin(), kChunks);
  EXPECT_EQ(*episodes.rbegin() - *episodes.begin() + 1, episodes.size());
}

TEST(ReplayTable, TheIndexStaysWithinTheMemoryBound) {
  SystemClock clock;
  TableOptions options = Options();
  options.replay.max_disk_bytes = int64_t{1} << 30;
  options.replay.max_memory_bytes = 200000;
  auto table = ReplayTable::Open(options, clock).value();
  for (uint64_t sequence = 1; sequence <= 3000; ++sequence) {
    ASSERT_TRUE(table->Insert(EpisodeChunk(sequence)));
    ASSERT_LE(table->stats().index_bytes, 200000u);
  }
  EXPECT_GT(table->stats().items, 1000u);
}

TEST(ReplayTable, AChunkLargerThanTheDiskBoundIsRefusedAndTheRestGoesOn) {
  SystemClock clock;
  TableOptions options = Options();
  options.replay.max_disk_bytes = 2000;
  auto table = ReplayTable::Open(options, clock).value();
  const auto refused = table->Insert(EpisodeChunk(1, 60));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kExhausted);
  EXPECT_THAT(refused.error().message, testing::HasSubstr("max_disk_bytes"));
  EXPECT_EQ(table->Insert(EpisodeChunk(1, 2)), Insertion::kStored);
}

TEST(ReplayTable, SamplesWhileInsertsAndDropsGoOn) {
  SystemClock clock;
  MemoryFolder folder;
  TableOptions options = Options(folder.path());
  options.replay.max_disk_bytes = 100000;
  options.replay.sampler = SamplerKind::kPrioritized;
  auto table = ReplayTable::Open(options, clock).value();
  ASSERT_TRUE(table->Insert(EpisodeChunk(1)));
  std::atomic<bool> done{false};
  std::atomic<int> wrong{0};
  std::thread sampler([&] {
    while (!done) {
      const auto batch = table->Sample({64, 1}, 0);
      if (!batch) {
        ++wrong;
        continue;
      }
      std::vector<uint64_t> keys;
      for (const SampledTrajectory& item : batch->trajectories) {
        wrong += Decode(item.payloads.front()) != item.steps[0].reward;
        keys.push_back(item.key);
      }
      table->UpdatePriorities(keys, std::vector<float>(keys.size(), 2.0f));
      table->TrimMemory();
    }
  });
  for (uint64_t sequence = 2; sequence <= 1500; ++sequence)
    ASSERT_TRUE(table->Insert(EpisodeChunk(sequence)));
  done = true;
  sampler.join();
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace dadrl
