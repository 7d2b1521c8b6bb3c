#include "replay/storage/segment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <string>

#include "common/io/byte_io.h"
#include "replay/storage/segment_format.h"
#include "replay/storage/segment_log.h"
#include "tests/replay/test_chunks.h"

namespace dadrl {
namespace {

constexpr uint64_t kSchema = 42;

std::vector<std::byte> Record(uint64_t seed) {
  Random random(seed);
  std::vector<std::byte> bytes(1 + random.Below(90));
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random.Next());
  return bytes;
}

struct Contents {
  std::vector<std::vector<std::byte>> records;
  Segment::Scan scan;
};

Contents Read(const std::filesystem::path& path, uint64_t id = 1) {
  Contents contents;
  const auto segment = Segment::Open(path, id, kSchema);
  EXPECT_TRUE(segment) << segment.error().message;
  if (!segment) return contents;
  contents.scan = (*segment)->Recover([&](std::span<const std::byte> record) {
    contents.records.emplace_back(record.begin(), record.end());
    return true;
  });
  return contents;
}

class SegmentFile : public testing::Test {
 protected:
  void SetUp() override {
    const auto segment = Segment::Create(path_, 1, kSchema, 1 << 16).value();
    for (uint64_t i = 0; i < 12; ++i) {
      records_.push_back(Record(i));
      const auto stored = segment->Append(records_.back());
      ASSERT_TRUE(stored);
      EXPECT_TRUE(std::ranges::equal(*stored, records_.back()));
      ends_.push_back(segment->bytes());
    }
    std::ifstream file(path_, std::ios::binary);
    bytes_.assign(std::istreambuf_iterator<char>(file), {});
  }
  void Rewrite(const std::string& bytes) {
    std::ofstream file(path_, std::ios::binary | std::ios::trunc);
    file << bytes;
  }

  MemoryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "segment";
  std::vector<std::vector<std::byte>> records_;
  std::vector<uint64_t> ends_;
  std::string bytes_;
};

// As another program computed it from the format: old files and new ones stay the same.
TEST(SegmentFormat, HeaderHasTheBytesOfItsFormat) {
  const std::vector<std::byte> header = EncodeSegmentHeader(7, 42);
  ASSERT_EQ(header.size(), kSegmentHeader);
  EXPECT_EQ(ByteReader(std::span(header).last(8)).Get<uint64_t>(), 0x5124f84e1b6cc7c0u);
  const SegmentHeader parsed = ParseSegmentHeader(header);
  EXPECT_TRUE(parsed.whole);
  EXPECT_EQ(parsed.id, 7u);
  EXPECT_EQ(parsed.schema, 42u);
}

TEST_F(SegmentFile, ComesBackWhole) {
  const Contents contents = Read(path_);
  EXPECT_EQ(contents.records, records_);
  EXPECT_EQ(contents.scan.dropped_bytes, 0u);
}

TEST(SegmentName, EachIdHasOne) {
  EXPECT_EQ(SegmentLog::IdOf("run/segment-000000000001.log"), 1u);
  EXPECT_EQ(SegmentLog::IdOf(SegmentLog::NameOf(kMaxSegmentId)), kMaxSegmentId);
  for (const char* name :
       {"segment-1.log", "segment-0000000000001.log", "segment-000000000000.log", "segment-004294967296.log",
        "segment-18446744073709551617.log", "segment--00000000001.log", "segment-000000000001x.log",
        "segment-.log", "segment-000000000001.log.old", "state"}) {
    EXPECT_EQ(SegmentLog::IdOf(name), std::nullopt) << name;
  }
}

TEST_F(SegmentFile, AfterTruncationAtAnyByteTheWholeRecordsAreThereAndTheTornEndIsCut) {
  for (size_t length = 0; length < bytes_.size(); ++length) {
    Rewrite(bytes_.substr(0, length));
    const Contents contents = Read(path_);
    // Padding carries nothing: a record is whole once its content is.
    size_t whole = 0;
    for (uint64_t begin = 40; whole < ends_.size(); begin = ends_[whole++]) {
      if (begin + 24 + records_[whole].size() > length) break;
    }
    ASSERT_EQ(contents.records.size(), whole) << length;
    EXPECT_TRUE(std::equal(contents.records.begin(), contents.records.end(), records_.begin()));
    const Contents again = Read(path_);
    EXPECT_EQ(again.records, contents.records);
    EXPECT_EQ(again.scan.dropped_bytes, 0u) << length;
  }
}

TEST_F(SegmentFile, AFlippedBitCostsTheRecordItIsInAndNoOther) {
  for (size_t byte = 0; byte < bytes_.size(); ++byte) {
    std::string damaged = bytes_;
    damaged[byte] = static_cast<char>(damaged[byte] ^ (1 << (byte % 8)));
    Rewrite(damaged);
    const Contents contents = Read(path_);
    ASSERT_GE(contents.records.size(), records_.size() - 1) << byte;
    for (const auto& record : contents.records) {
      ASSERT_NE(std::find(records_.begin(), records_.end(), record), records_.end()) << byte;
    }
  }
}

TEST_F(SegmentFile, RecordsOfAnotherSegmentAreNotTakenForItsOwn) {
  const Contents contents = Read(path_, /*id=*/2);
  EXPECT_TRUE(contents.records.empty());
  EXPECT_GT(contents.scan.dropped_bytes, 0u);
}

TEST_F(SegmentFile, AnotherSchemaIsRefusedWithTheFileAndTheRemedy) {
  const auto segment = Segment::Open(path_, 1, kSchema + 1);
  ASSERT_FALSE(segment);
  EXPECT_EQ(segment.error().code, ErrorCode::kCorrupt);
  EXPECT_THAT(segment.error().message, testing::HasSubstr(path_.string()));
  EXPECT_THAT(segment.error().message, testing::HasSubstr("run directory"));
}

// In a child, because the limit on the size of files is its whole process's.
int AppendBeyondTheRoom(const std::filesystem::path& path) {
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const auto segment = Segment::Create(path, 1, kSchema, 1 << 16).value();
    const bool first = segment->Append(Record(1)).has_value();
    const rlimit full{segment->bytes() + 30, RLIM_INFINITY};  // for a header, and some of the content
    setrlimit(RLIMIT_FSIZE, &full);
    const bool second = segment->Append(std::vector<std::byte>(500)).has_value();
    _exit(first && !second ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

TEST(Segment, ARecordThatDoesNotFitOntoTheDiskLeavesNothing) {
  const MemoryFolder folder;
  const auto path = folder.path() / "segment";
  ASSERT_EQ(AppendBeyondTheRoom(path), 0);
  const Contents contents = Read(path);
  EXPECT_EQ(contents.records.size(), 1u);
  EXPECT_EQ(contents.scan.dropped_bytes, 0u);
}

TEST(Segment, ReadersKeepWhatTheyHoldAfterTheFileIsGone) {
  MemoryFolder folder;
  std::span<const std::byte> stored;
  std::shared_ptr<const Segment> held;
  const auto record = Record(1);
  {
    auto segment = Segment::Create(folder.path() / "s", 1, kSchema, 4096).value();
    stored = segment->Append(record).value();
    segment->Unlink();
    held = segment;
  }
  held->DropPages();
  EXPECT_TRUE(std::ranges::equal(stored, record));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "s"));
}

size_t OpenDescriptors() {
  return static_cast<size_t>(std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {}));
}

TEST(Segment, HoldsADescriptorOnlyWhileItGrowsAndIsForcedAllTheSame) {
  MemoryFolder folder;
  const size_t before = OpenDescriptors();
  std::vector<std::shared_ptr<Segment>> segments;
  for (uint64_t id = 1; id <= 50; ++id) {
    segments.push_back(Segment::Create(folder.path() / fmt::format("{}", id), id, kSchema, 4096).value());
    ASSERT_TRUE(segments.back()->Append(Record(id)));
    EXPECT_EQ(OpenDescriptors(), before + 1);
    segments.back()->Seal();
    ASSERT_TRUE(segments.back()->Sync());
  }
  EXPECT_EQ(OpenDescriptors(), before);
}

TEST(Segment, OneThatWasRemovedHasNothingToForce) {
  MemoryFolder folder;
  const auto segment = Segment::Create(folder.path() / "s", 1, kSchema, 4096).value();
  segment->Seal();
  segment->Unlink();
  EXPECT_TRUE(segment->Sync());
}

TEST(Segment, ASealedOneThatIsGoneWithoutOurDoingIsNotTakenForForced) {
  MemoryFolder folder;
  const auto segment = Segment::Create(folder.path() / "s", 1, kSchema, 4096).value();
  segment->Seal();
  std::filesystem::remove(folder.path() / "s");
  EXPECT_FALSE(segment->Sync());
}

TEST(SegmentLog, ASecondProcessIsKeptOut) {
  MemoryFolder folder;
  SegmentLog::Recovery recovery;
  const auto visit = [](const auto&, std::span<const std::byte>) { return true; };
  const auto first = SegmentLog::Open({folder.path(), kSchema}, visit, recovery);
  ASSERT_TRUE(first);
  const auto second = SegmentLog::Open({folder.path(), kSchema}, visit, recovery);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(second.error().message, testing::HasSubstr(folder.path().string()));
}

TEST(SegmentLog, GoesOnInANewSegmentWithANewId) {
  MemoryFolder folder;
  std::vector<uint64_t> ids;
  for (int run = 0; run < 3; ++run) {
    ids.clear();
    SegmentLog::Recovery recovery;
    auto log = SegmentLog::Open(
                   {folder.path(), kSchema},
                   [&](const auto& segment, std::span<const std::byte>) {
                     ids.push_back(segment->id());
                     return true;
                   },
                   recovery)
                   .value();
    ASSERT_TRUE(log->StartSegment(10));
    ASSERT_TRUE(log->Append(Record(static_cast<uint64_t>(run))));
  }
  EXPECT_EQ(ids, (std::vector<uint64_t>{1, 2}));
}

}  // namespace
}  // namespace dadrl
