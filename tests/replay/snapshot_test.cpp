// Snapshots: a moment of a replay that goes on meanwhile.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <map>
#include <set>
#include <thread>

#include "replay/storage/columns_file.h"
#include "replay/storage/snapshot_folder.h"
#include "replay/table.h"
#include "tests/replay/test_chunks.h"

namespace dadrl {
namespace {

constexpr int kFrames = 8;  // of a chunk; each is an episode

class SnapshotTest : public testing::Test {
 protected:
  SnapshotTest() {
    options_ = {.directory = folder_.path() / "replay", .spec = kTestSpec, .replay = {}, .n_step = 1};
    options_.replay.min_size = 1;
    options_.replay.samples_per_insert = 0.0;
    options_.replay.max_disk_bytes = 1 << 20;
    options_.replay.segment_bytes = 1 << 16;
    options_.replay.sampler = SamplerKind::kPrioritized;
    options_.replay.priority_exponent = 1.0;
    options_.replay.sync = SyncMode::kNone;
  }
  std::unique_ptr<ReplayTable> Open(const std::filesystem::path& directory) {
    TableOptions options = options_;
    options.directory = directory;
    auto table = ReplayTable::Open(options, clock_);
    EXPECT_TRUE(table) << table.error().message;
    return std::move(*table);
  }
  static std::vector<std::byte> Chunk(uint64_t sequence) {
    return Build({.identity = {1, 7, sequence}, .episode = sequence, .frames = kFrames, .end = kTerminated});
  }
  // The episodes that can be sampled, which must be whole and without a gap.
  static std::set<uint64_t> Episodes(ReplayTable& table) {
    std::map<uint64_t, std::set<uint64_t>> frames;
    size_t found = 0;
    while (found < table.stats().items) {
      const auto batch = table.Sample({512, 1}, 0).value();
      for (const SampledTrajectory& item : batch.trajectories) {
        const auto value = static_cast<uint64_t>(item.steps[0].reward / kTestScale) - 10000;
        found += frames[value / 100].insert(value % 100).second;
      }
    }
    std::set<uint64_t> episodes;
    for (const auto& [episode, numbers] : frames) {
      EXPECT_EQ(numbers.size(), static_cast<size_t>(kFrames)) << episode;
      episodes.insert(episode);
    }
    return episodes;
  }

  SystemClock clock_;
  MemoryFolder folder_;
  TableOptions options_;
};

TEST_F(SnapshotTest, HoldsContentsPrioritiesLimiterAndExactlyOnceTable) {
  auto table = Open(options_.directory);
  for (uint64_t sequence = 1; sequence <= 300; ++sequence) ASSERT_TRUE(table->Insert(Chunk(sequence)));
  std::map<uint64_t, float> probabilities;
  const auto sampled = table->Sample({2000, 1}, 3).value();
  for (const SampledTrajectory& item : sampled.trajectories) {
    table->UpdatePriorities({{item.key}}, {{1.0f + static_cast<float>(item.key % 5)}});
  }
  const auto snapshot = folder_.path() / "snapshot";
  const auto report = table->Snapshot(snapshot);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_GT(report->segments, 2u);
  EXPECT_LT(report->copied_bytes, options_.replay.segment_bytes) << "only the open segment is copied";
  const auto before = table->stats();
  while (probabilities.size() < before.items) {
    const auto batch = table->Sample({512, 1}, 0).value();
    for (const SampledTrajectory& item : batch.trajectories) probabilities[item.key] = item.probability;
  }
  // What comes later is not in it.
  for (uint64_t sequence = 301; sequence <= 320; ++sequence) ASSERT_TRUE(table->Insert(Chunk(sequence)));

  auto restored = Open(snapshot);
  const auto after = restored->stats();
  EXPECT_EQ(after.frames_held, before.frames_held);
  EXPECT_EQ(after.items, before.items);
  EXPECT_EQ(after.inserted_frames, before.inserted_frames);
  EXPECT_EQ(after.sampled, before.sampled);
  EXPECT_EQ(restored->Stored(1, 7), 300u);
  EXPECT_EQ(restored->Insert(Chunk(300)), ReplayTable::Insertion::kDuplicate);
  std::map<uint64_t, float> again;
  while (again.size() < after.items) {
    const auto batch = restored->Sample({512, 1}, 0).value();
    for (const SampledTrajectory& item : batch.trajectories) again[item.key] = item.probability;
  }
  EXPECT_EQ(again, probabilities);
  EXPECT_EQ(restored->Insert(Chunk(301)), ReplayTable::Insertion::kStored);
}

TEST_F(SnapshotTest, IsOneMomentWhileInsertsSamplesAndDropsGoOn) {
  options_.replay.max_disk_bytes = 1 << 18;  // the oldest are dropped all the time
  auto table = Open(options_.directory);
  uint64_t stored = 0;
  while (stored < 400) ASSERT_TRUE(table->Insert(Chunk(++stored)));
  std::atomic<bool> stop{false};
  std::atomic<uint64_t> inserted{stored};
  std::atomic<uint64_t> sampled{0};
  std::thread inserter([&] {
    for (uint64_t sequence = stored + 1; !stop; ++sequence) {
      ASSERT_EQ(table->Insert(Chunk(sequence)), ReplayTable::Insertion::kStored);
      inserted.store(sequence);
    }
  });
  std::thread sampler([&] {
    while (!stop) {
      const auto batch = table->Sample({64, 1}, 0).value();
      for (const SampledTrajectory& item : batch.trajectories)
        table->UpdatePriorities({{item.key}}, {{2.0f}});
      sampled.fetch_add(batch.trajectories.size());
    }
  });
  std::vector<std::array<uint64_t, 2>> between;
  for (int i = 0; i < 8; ++i) {
    const uint64_t before = inserted.load();
    const uint64_t samples_before = sampled.load();
    const auto report = table->Snapshot(folder_.path() / fmt::format("snapshot-{}", i));
    ASSERT_TRUE(report) << report.error().message;
    between.push_back({before, inserted.load()});
    // Traffic is not waiting for anything now: it goes on.
    while (inserted.load() < between.back()[1] + 50 || sampled.load() < samples_before + 64) {
      std::this_thread::yield();
    }
  }
  stop = true;
  inserter.join();
  sampler.join();
  for (size_t i = 0; i < between.size(); ++i) {
    auto restored = Open(folder_.path() / fmt::format("snapshot-{}", i));
    const uint64_t last = restored->Stored(1, 7).value();
    EXPECT_GE(last, between[i][0]);
    EXPECT_LE(last, between[i][1] + 1) << "one insert may be between storing and saying so";
    // Everything up to that moment and nothing behind it, without a hole.
    const auto episodes = Episodes(*restored);
    ASSERT_FALSE(episodes.empty());
    EXPECT_EQ(*episodes.rbegin(), last);
    EXPECT_EQ(episodes.size(), last - *episodes.begin() + 1);
    EXPECT_EQ(restored->stats().inserted_frames, last * kFrames);
  }
}

TEST_F(SnapshotTest, OfSegmentsThatWereDroppedMeanwhileItIsACopy) {
  auto table = Open(options_.directory);
  for (uint64_t sequence = 1; sequence <= 200; ++sequence) ASSERT_TRUE(table->Insert(Chunk(sequence)));
  SegmentLog::Recovery recovery;
  table.reset();
  auto log = SegmentLog::Open(
                 {options_.directory, SchemaHash(options_.spec), 1 << 16},
                 [](const auto&, auto) { return true; }, recovery)
                 .value();
  const auto extents = log->Extents();
  log->RemoveOldest();
  const auto snapshot = folder_.path() / "snapshot";
  const auto report = WriteSnapshot({.schema = SchemaHash(options_.spec)}, options_.spec, extents, snapshot);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->copied_bytes, extents.front().bytes);
  EXPECT_EQ(Open(snapshot)->Stored(1, 7), 200u);
}

TEST_F(SnapshotTest, CostsWhatTheReplayHasDroppedSinceAndWhatWasCopiedOnce) {
  const auto snapshots = folder_.path() / "snapshots";
  const auto use = [&] { return UseOfSnapshots(snapshots, options_.directory); };
  EXPECT_EQ(use().snapshots, 0u);
  auto table = Open(options_.directory);
  uint64_t sequence = 0;
  const auto insert = [&](int count) {
    for (int i = 0; i < count; ++i) ASSERT_TRUE(table->Insert(Chunk(++sequence)));
  };
  insert(600);
  const uint64_t held = table->stats().disk_bytes;
  ASSERT_GT(held, uint64_t{3} << 16);
  const SnapshotReport first = table->Snapshot(snapshots / "first").value();
  ASSERT_TRUE(table->Snapshot(snapshots / "second"));
  const uint64_t state_bytes = std::filesystem::file_size(snapshots / "first" / "state") +
                               std::filesystem::file_size(snapshots / "first" / kColumnsFile);
  EXPECT_EQ(use().snapshots, 2u);
  EXPECT_EQ(use().bytes, 2 * (first.copied_bytes + state_bytes));
  // Until the replay has dropped all that it held then.
  while (std::filesystem::exists(options_.directory / "segment-000000000001.log")) insert(10);
  const uint64_t one_dropped = use().bytes;
  EXPECT_GE(one_dropped, 2 * (first.copied_bytes + state_bytes) + (uint64_t{1} << 15));
  insert(8000);
  EXPECT_EQ(use().bytes, first.bytes + first.copied_bytes + 2 * state_bytes) << "what both hold counts once";
  std::filesystem::remove_all(snapshots / "first");
  EXPECT_EQ(use().snapshots, 1u);
  EXPECT_EQ(use().bytes, first.bytes + state_bytes);
}

TEST_F(SnapshotTest, FailsWholeAndSaysWhy) {
  auto table = Open(options_.directory);
  ASSERT_TRUE(table->Insert(Chunk(1)));
  const auto taken = folder_.path() / "taken";
  std::filesystem::create_directories(taken);
  const auto refused = table->Snapshot(taken);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, testing::HasSubstr("taken"));
  std::ofstream(folder_.path() / "file") << "x";
  const auto blocked = table->Snapshot(folder_.path() / "file" / "snapshot");
  ASSERT_FALSE(blocked);
  EXPECT_THAT(blocked.error().message, testing::HasSubstr("file"));
  EXPECT_EQ(table->Insert(Chunk(2)), ReplayTable::Insertion::kStored);
}

TEST(NextSnapshotName, SortsBehindTheNewestAlsoWhenTheClockWasSetBack) {
  const TemporaryFolder folder;
  constexpr int64_t kNoon = 1'780'000'000'000'000'000;
  constexpr int64_t kYear = int64_t{365} * 24 * 3600 * 1'000'000'000;
  EXPECT_EQ(NextSnapshotName(folder.path() / "absent", kNoon), AutomaticSnapshotName(kNoon));
  std::string last;
  for (const int64_t now : {kNoon, kNoon - kYear, kNoon - kYear, kNoon + kYear, kNoon}) {
    const std::string name = NextSnapshotName(folder.path(), now);
    EXPECT_GT(name, last);
    std::filesystem::create_directories(folder.path() / name);
    last = name;
  }
  std::filesystem::create_directories(folder.path() / "zzz-named-by-hand");
  ASSERT_TRUE(RemoveOldSnapshots(folder.path(), 1));
  EXPECT_TRUE(std::filesystem::exists(folder.path() / last));
}

}  // namespace
}  // namespace dadrl
