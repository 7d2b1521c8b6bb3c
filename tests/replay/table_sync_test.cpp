// What is forced to the device, when, and what a disk that fails does to it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <set>

#include "replay/table.h"
#include "tests/replay/test_chunks.h"

namespace dadrl {
namespace {

using Insertion = ReplayTable::Insertion;

// A disk whose forced writes are counted, and fail while `broken`.
struct TestDisk {
  std::vector<std::string> forced;  // names of files, in order
  bool broken = false;

  Segment::Force Force() {
    return [this](const FileDescriptor& file, const std::filesystem::path& path) -> Status {
      if (broken) return Fail(ErrorCode::kInternal, "cannot force {}", path.string());
      forced.push_back(path.filename().string());
      return SyncFile(file, path);
    };
  }
};

class TableSync : public testing::Test {
 protected:
  TableOptions Options(SyncMode sync) {
    TableOptions options;
    options.directory = folder_.path();
    options.spec = kTestSpec;
    options.replay.min_size = 1;
    options.replay.samples_per_insert = 0.0;
    options.replay.max_disk_bytes = 1 << 20;
    options.replay.segment_bytes = 1 << 12;
    options.replay.sync = sync;
    options.force = disk_.Force();
    return options;
  }
  std::unique_ptr<ReplayTable> Open(SyncMode sync = SyncMode::kInterval) {
    return ReplayTable::Open(Options(sync), clock_).value();
  }
  static std::vector<std::byte> Chunk(uint64_t sequence) {
    return Build(
        {.identity = {1, 7, sequence}, .episode = sequence, .frames = 5, .end = uint8_t{kTerminated}});
  }
  // Inserts until so many segment files are there.
  void FillSegments(ReplayTable& table, size_t count) {
    while (SegmentFiles().size() < count) {
      ASSERT_EQ(table.Insert(Chunk(++stored_)), Insertion::kStored);
    }
  }
  std::set<std::string> SegmentFiles() const {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
      if (SegmentLog::IdOf(entry.path())) names.insert(entry.path().filename().string());
    }
    return names;
  }
  std::set<std::string> Forced() const { return {disk_.forced.begin(), disk_.forced.end()}; }

  SystemClock clock_;
  MemoryFolder folder_;
  TestDisk disk_;
  uint64_t stored_ = 0;
};

TEST_F(TableSync, FullSegmentsAreLeftToTheNextSyncWhichForcesAll) {
  const auto table = Open();
  FillSegments(*table, ReplayTable::kMaxUnforced);
  EXPECT_THAT(disk_.forced, testing::IsEmpty()) << "an insert waited for the disk";
  ASSERT_TRUE(table->Sync());
  EXPECT_EQ(Forced(), SegmentFiles());
  disk_.forced.clear();
  ASSERT_TRUE(table->Sync());
  EXPECT_EQ(Forced(), std::set<std::string>{*SegmentFiles().rbegin()}) << "full ones never change again";
}

TEST_F(TableSync, InsertsWaitForADiskThatDoesNotKeepUp) {
  const auto table = Open();
  FillSegments(*table, ReplayTable::kMaxUnforced + 2);
  EXPECT_GE(disk_.forced.size(), ReplayTable::kMaxUnforced);
}

TEST_F(TableSync, WithoutAPromiseNothingIsForced) {
  const auto table = Open(SyncMode::kNone);
  FillSegments(*table, 3 * ReplayTable::kMaxUnforced);
  ASSERT_TRUE(table->SaveState());
  EXPECT_THAT(disk_.forced, testing::IsEmpty());
}

TEST_F(TableSync, TheStateIsSavedForANewSegmentAndNotAgain) {
  const auto table = Open();
  FillSegments(*table, 2);
  const std::filesystem::path state = folder_.path() / "state";
  ASSERT_TRUE(table->SaveStateOfNewSegment());
  ASSERT_TRUE(std::filesystem::remove(state));
  ASSERT_TRUE(table->SaveStateOfNewSegment());
  EXPECT_FALSE(std::filesystem::exists(state));
  FillSegments(*table, 3);
  ASSERT_TRUE(table->SaveStateOfNewSegment());
  EXPECT_TRUE(std::filesystem::exists(state));
}

TEST_F(TableSync, WhatCannotBeForcedIsSaidKeptAndForcedLater) {
  {
    const auto table = Open();
    FillSegments(*table, 2);
    disk_.broken = true;
    EXPECT_FALSE(table->Sync());
    EXPECT_FALSE(table->SaveState()) << "a state must not count what may be lost behind it";
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "state"));
    // Up to the bound inserts go on, then they are refused: the actors keep what they have.
    Result<Insertion> inserted = Insertion::kStored;
    while (inserted) {
      inserted = table->Insert(Chunk(stored_ + 1));
      if (inserted) ++stored_;
      ASSERT_LT(SegmentFiles().size(), 3 * ReplayTable::kMaxUnforced);
    }
    EXPECT_GT(SegmentFiles().size(), ReplayTable::kMaxUnforced);
    EXPECT_THAT(inserted.error().message, testing::HasSubstr("cannot force"));
    disk_.broken = false;
    ASSERT_EQ(table->Insert(Chunk(++stored_)), Insertion::kStored) << "the same chunk once more";
    ASSERT_TRUE(table->Sync());
    EXPECT_EQ(Forced(), SegmentFiles());
  }
  const auto table = Open();
  EXPECT_EQ(table->Stored(1, 7), stored_);
  EXPECT_EQ(table->stats().frames_held, stored_ * 5);
}

TEST_F(TableSync, AStartWithMoreThanItMayHoldAndADiskThatFailsServesWhatIsThere) {
  {
    const auto table = Open(SyncMode::kNone);
    FillSegments(*table, 5);
  }
  disk_.broken = true;  // no state can be saved, so no segment may leave
  TableOptions smaller = Options(SyncMode::kInterval);
  smaller.replay.max_disk_bytes = 1 << 13;
  const auto table = ReplayTable::Open(smaller, clock_);
  ASSERT_TRUE(table) << table.error().message;
  EXPECT_EQ((*table)->stats().frames_held, stored_ * 5);
  EXPECT_FALSE((*table)->Insert(Chunk(stored_ + 1)));
  disk_.broken = false;
  EXPECT_EQ((*table)->Insert(Chunk(stored_ + 1)), Insertion::kStored);
  EXPECT_LT((*table)->stats().frames_held, stored_ * 5);
}

TEST_F(TableSync, WhatAKilledProcessDidNotForceIsForcedByTheNextOne) {
  FillSegments(*Open(), 3);
  ASSERT_THAT(disk_.forced, testing::IsEmpty());
  const auto table = Open();
  ASSERT_TRUE(table->SaveState()) << "as the service does before it acknowledges what it found";
  EXPECT_EQ(Forced(), SegmentFiles());
}

// Files of this process cannot grow or be written beyond `bytes` while it lives.
class FileLimit {
 public:
  explicit FileLimit(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    handler_ = signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    signal(SIGXFSZ, handler_);
  }
  FileLimit(const FileLimit&) = delete;
  FileLimit& operator=(const FileLimit&) = delete;

 private:
  rlimit before_{};
  sighandler_t handler_ = nullptr;
};

TEST_F(TableSync, AfterAFailureEverythingIsWrittenOnceMoreBeforeItIsBelieved) {
  const auto table = Open();
  FillSegments(*table, 1);
  disk_.broken = true;
  ASSERT_FALSE(table->Sync());
  disk_.broken = false;
  {
    const FileLimit nothing_can_be_written(0);
    EXPECT_FALSE(table->Sync()) << "a system that failed to write says of the next force that all is well";
  }
  EXPECT_TRUE(table->Sync());
  EXPECT_TRUE(table->Sample({5, 1}, 0)) << "it is still what it was";
}

}  // namespace
}  // namespace dadrl
