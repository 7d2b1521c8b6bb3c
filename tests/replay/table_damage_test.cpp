// What a restart finds after damage: whatever is whole, once, and nothing else.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "replay/storage/segment_format.h"
#include "replay/storage/segment_log.h"
#include "tests/common/util/captured_log.h"
#include "tests/replay/table_recovery_fixture.h"

namespace dadrl {
namespace {

using TableDamage = TableRecovery;

// Oldest first.
std::vector<std::filesystem::path> Segments(const std::filesystem::path& directory) {
  std::vector<std::filesystem::path> segments;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    if (SegmentLog::IdOf(entry.path())) segments.push_back(entry.path());
  }
  std::sort(segments.begin(), segments.end());
  return segments;
}

TEST_F(TableDamage, ADamagedStateFileCostsOnlyTheCounters) {
  {
    auto table = Open();
    Store(*table, 1, 4);
    ASSERT_TRUE(table->SaveState());
  }
  std::ofstream(folder_.path() / "state", std::ios::trunc) << "nonsense";
  auto table = Open();
  EXPECT_EQ(table->Stored(1, 7), 4u);
  EXPECT_EQ(table->stats().items, 20u);
}

TEST_F(TableDamage, ALinkAmongTheSegmentsIsNeitherReadNorWrittenTo) {
  MemoryFolder theirs;
  {
    auto table = Open();
    Store(*table, 1, 4);
  }
  const auto segment = Segments(folder_.path()).at(0);
  const auto moved = theirs.path() / "theirs";
  std::filesystem::copy_file(segment, moved);
  std::filesystem::resize_file(moved, std::filesystem::file_size(moved) - 1);  // a recovery would cut it
  const auto size = std::filesystem::file_size(moved);
  std::filesystem::create_symlink(moved, folder_.path() / "segment-000000000077.log");
  auto table = Open();
  EXPECT_EQ(table->stats().items, 20u);
  EXPECT_EQ(std::filesystem::file_size(moved), size);
}

TEST_F(TableDamage, TruncatedAtAnyByteItHoldsTheWholeChunksAndGoesOn) {
  {
    auto table = Open();
    Store(*table, 1, 3);
  }
  const auto path = Segments(folder_.path()).at(0);
  std::ifstream file(path, std::ios::binary);
  const std::string whole(std::istreambuf_iterator<char>(file), {});
  for (size_t length = 0; length <= whole.size(); length += 1) {
    MemoryFolder folder;
    std::ofstream(folder.path() / path.filename(), std::ios::binary) << whole.substr(0, length);
    auto table = Open(Options(folder.path()));
    const uint64_t stored = table->Stored(1, 7).value_or(0);
    ASSERT_EQ(table->stats().frames_held, stored * 5) << length;
    // What the actor sends again goes on exactly there.
    for (uint64_t sequence = 1; sequence <= 4; ++sequence) {
      ASSERT_EQ(table->Insert(Build(ChunkOf(sequence)), 1),
                sequence <= stored ? Insertion::kDuplicate : Insertion::kStored);
    }
    ASSERT_EQ(SampleAll(*table).size(), 20u) << length;
  }
}

TEST_F(TableDamage, ADamagedRecordCostsItsChunkAndNothingElse) {
  {
    auto table = Open();
    Store(*table, 1, 6);
  }
  const auto path = Segments(folder_.path()).at(0);
  const auto size = std::filesystem::file_size(path);
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(size / 2));
  file << "XXXX";
  file.close();
  auto table = Open();
  EXPECT_EQ(table->stats().frames_held, 25u);
  EXPECT_EQ(table->Stored(1, 7), 6u);
  for (const auto& [first, rewards] : SampleAll(*table)) {
    // No slice bridges the hole.
    if (rewards.size() == 2) {
      EXPECT_EQ(rewards[1], first + kTestScale);
    }
  }
}

TEST_F(TableDamage, HundredsOfRandomDamagesCostTheirChunksAndNothingElse) {
  constexpr uint64_t kChunks = 300;
  constexpr int kCases = 400;
  TableOptions options = Options(folder_.path() / "whole");
  std::map<uint64_t, std::vector<std::byte>> chunks;
  {
    const auto table = Open(options);
    for (uint64_t sequence = 1; sequence <= kChunks; ++sequence) {
      chunks[sequence] = Build(ChunkOf(sequence));
      ASSERT_EQ(table->Insert(chunks[sequence]), Insertion::kStored);
    }
  }
  Random random(400);
  for (int damage = 0; damage < kCases; ++damage) {
    options.directory = folder_.path() / "damaged";
    std::filesystem::remove_all(options.directory);
    std::filesystem::copy(folder_.path() / "whole", options.directory);
    const auto segments = Segments(options.directory);
    ASSERT_GE(segments.size(), 2u);
    const auto& victim = segments[random.Below(segments.size())];
    const uint64_t size = std::filesystem::file_size(victim);
    const uint64_t flips = random.Below(4);
    for (uint64_t i = 0; i < flips; ++i) {
      std::fstream file(victim, std::ios::in | std::ios::out | std::ios::binary);
      const auto at = static_cast<std::streamoff>(random.Below(size));
      file.seekg(at);
      const auto byte = static_cast<char>(file.get() ^ (1 << random.Below(8)));
      file.seekp(at);
      file.put(byte);
    }
    const uint64_t cut = flips == 0 ? 1 + random.Below(size) : 0;
    if (cut > 0) std::filesystem::resize_file(victim, size - cut);

    SegmentLog::Recovery recovery;
    std::map<uint64_t, int> found;
    const auto log = SegmentLog::Open(
        {options.directory, SchemaHash(options.spec)},
        [&](const auto&, std::span<const std::byte> record) {
          const auto chunk = ChunkView::Parse(record);
          if (!chunk) return false;
          const uint64_t sequence = chunk->header().identity.sequence;
          EXPECT_TRUE(
              std::equal(record.begin(), record.end(), chunks[sequence].begin(), chunks[sequence].end()));
          ++found[sequence];
          return true;
        },
        recovery);
    ASSERT_TRUE(log) << log.error().message;
    for (const auto& [sequence, copies] : found) EXPECT_EQ(copies, 1) << sequence;
    const uint64_t record = Segment::RecordBytes(chunks[1].size());
    const uint64_t lost = cut > 0 ? cut / (record - 64) + 1 : flips;
    EXPECT_GE(found.size() + lost, kChunks) << "case " << damage;
  }
}

TEST_F(TableDamage, WhatIsNoFileOfOursIsLeftAlone) {
  {
    auto table = Open();
    Store(*table, 1, 6);
  }
  namespace fs = std::filesystem;
  const MemoryFolder elsewhere;
  const fs::path secret = elsewhere.path() / "secret";
  std::ofstream(secret) << "of somebody else";
  const auto named = [&](uint64_t id) { return folder_.path() / SegmentLog::NameOf(id); };
  fs::create_symlink(secret, named(20));
  ASSERT_EQ(mkfifo(named(21).c_str(), 0600), 0);
  fs::create_directory(named(22));
  std::ofstream(named(23)) << "sparse";
  fs::resize_file(named(23), kMaxSegmentBytes + 1);
  const CapturedLog log;
  auto table = Open();
  EXPECT_EQ(table->stats().frames_held, 30u);
  for (const uint64_t id : {20u, 21u, 22u, 23u})
    EXPECT_THAT(log.text(), testing::HasSubstr(named(id).string()));
  Store(*table, 7, 8);
  EXPECT_EQ(fs::file_size(secret), 16u);
  EXPECT_TRUE(fs::is_symlink(named(20)) && fs::is_fifo(named(21)) && fs::is_directory(named(22)));
  EXPECT_EQ(fs::file_size(named(23)), kMaxSegmentBytes + 1);
}

// Fills segments; chunk `sequence` holds the rewards that its first frame begins with.
class TableUnderASegmentThatGoesBad : public TableRecovery {
 protected:
  void SetUp() override {
    TableOptions options = Options(folder_.path());
    options.replay.segment_bytes = 1 << 12;
    options.replay.max_times_sampled = 0;
    table_ = Open(options);
    while (Segments(folder_.path()).size() < 4) Store(*table_, stored_ + 1, stored_ + 1), ++stored_;
  }
  // As a disk that fails: what was mapped is not there any more.
  void CutShort(size_t segment) { std::filesystem::resize_file(Segments(folder_.path()).at(segment), 0); }
  // Samples until something cannot be read.
  Status SampleMuch() {
    for (int i = 0; i < 200; ++i) {
      DADRL_ASSIGN_OR_RETURN(const SampledBatch batch, table_->Sample({16, 2}, 0));
      for (const SampledTrajectory& item : batch.trajectories) {
        if (Decode(item.payloads.front()) != item.steps[0].reward) return CheckReadable(batch.segments);
      }
      DADRL_RETURN_IF_ERROR(CheckReadable(batch.segments));
    }
    return {};
  }

  std::unique_ptr<ReplayTable> table_;
  uint64_t stored_ = 0;
};

TEST_F(TableUnderASegmentThatGoesBad, ItsFramesAreLostTheProcessIsNot) {
  ASSERT_TRUE(SampleMuch());
  ASSERT_TRUE(table_->DropDamaged());
  const uint64_t before = table_->stats().frames_held;
  CutShort(1);
  table_->TrimMemory();
  EXPECT_FALSE(SampleMuch());
  const Status damaged = table_->DropDamaged();
  ASSERT_FALSE(damaged);
  EXPECT_EQ(damaged.error().code, ErrorCode::kCorrupt);
  EXPECT_NE(damaged.error().message.find(Segments(folder_.path()).at(1).string()), std::string::npos);
  const uint64_t lost = table_->stats().damaged_frames;
  EXPECT_GT(lost, 0u);
  EXPECT_EQ(table_->stats().frames_held, before - lost);
  EXPECT_TRUE(SampleMuch()) << "what is left is sound, slices from the segment before included";
  ASSERT_FALSE(table_->DropDamaged()) << "it is still there";
  EXPECT_EQ(table_->stats().damaged_frames, lost) << "and is counted once";
}

TEST_F(TableUnderASegmentThatGoesBad, TheFaultIsOverWhenItsSegmentHasLeft) {
  CutShort(0);
  ASSERT_FALSE(SampleMuch());
  ASSERT_FALSE(table_->DropDamaged());
  while (std::filesystem::exists(folder_.path() / "segment-000000000001.log")) {
    Store(*table_, stored_ + 1, stored_ + 1);
    ++stored_;
  }
  EXPECT_TRUE(table_->DropDamaged());
}

TEST_F(TableUnderASegmentThatGoesBad, NothingIsAddedToTheOpenOneThatGoesBad) {
  CutShort(3);
  ASSERT_FALSE(SampleMuch());
  ASSERT_FALSE(table_->DropDamaged());
  Store(*table_, stored_ + 1, stored_ + 1);
  EXPECT_EQ(Segments(folder_.path()).size(), 5u);
  EXPECT_TRUE(SampleMuch());
}

TEST_F(TableUnderASegmentThatGoesBad, TheNextStartGoesOnWithTheRest) {
  CutShort(1);
  const uint64_t before = table_->stats().frames_held;
  table_.reset();
  table_ = Open();
  EXPECT_LT(table_->stats().frames_held, before);
  EXPECT_GT(table_->stats().frames_held, before / 2);
  EXPECT_EQ(table_->Stored(1, 7), stored_);
}

TEST_F(TableDamage, ASegmentThatCannotBeOpenedIsLeftOutAndStays) {
  {
    auto table = Open();
    Store(*table, 1, 4);
  }
  const auto path = Segments(folder_.path()).at(0);
  const auto foreign = folder_.path() / "segment-000000000007.log";
  std::filesystem::create_directory(foreign);  // opening it for writing fails, reading as well
  auto table = Open();
  EXPECT_EQ(table->Stored(1, 7), 4u);
  Store(*table, 5, 5);
  EXPECT_TRUE(std::filesystem::exists(path));
  EXPECT_TRUE(std::filesystem::exists(foreign));
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "segment-000000000008.log")) << "its number is taken";
}

}  // namespace
}  // namespace dadrl
