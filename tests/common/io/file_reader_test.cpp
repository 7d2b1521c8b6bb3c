#include "common/io/file_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/io/byte_io.h"
#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class FileReaderTest : public testing::Test {
 protected:
  // Appends the checksum and writes the file.
  void Seal() {
    AppendChecksum(bytes_);
    WritePlainly(path_, bytes_);
  }
  FileReader Open() { return FileReader::Open(path_, 1 << 30).value(); }

  TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_.path() / "values";
  std::vector<std::byte> bytes_;
  ByteWriter writer_{bytes_};
};

constexpr FileKind kKind{
    .magic = "DADRLXYZ", .name = "a thing", .oldest = 2, .format = 3, .remedy = "take another"};

TEST_F(FileReaderTest, ReadsTheFormatsOfItsKind) {
  for (const uint32_t format : {2u, 3u}) {
    bytes_.clear();
    FileKind written = kKind;
    written.format = format;
    written.PutHead(writer_);
    Seal();
    FileReader reader = Open();
    EXPECT_EQ(reader.GetHead(kKind), format);
    EXPECT_TRUE(reader.CheckEnd(kKind.remedy));
  }
  EXPECT_EQ(bytes_.size(), 8u + 4u + 8u);
}

TEST_F(FileReaderTest, RefusesAnotherKindAndFormatsThatItDoesNotRead) {
  for (const uint32_t format : {1u, 4u}) {
    bytes_.clear();
    FileKind written = kKind;
    written.format = format;
    written.PutHead(writer_);
    Seal();
    const auto head = Open().GetHead(kKind);
    EXPECT_EQ(head.error().code, ErrorCode::kInvalidArgument);
    EXPECT_THAT(head.error().message,
                AllOf(HasSubstr(path_.string()), HasSubstr("a thing of format " + std::to_string(format)),
                      HasSubstr("formats 2 to 3")));
  }
  bytes_[7] = std::byte{'!'};
  WritePlainly(path_, bytes_);
  for (const size_t length : {bytes_.size(), size_t{5}, size_t{0}}) {
    WritePlainly(path_, std::span(bytes_).first(length));
    const auto head = Open().GetHead(kKind);
    EXPECT_EQ(head.error().code, ErrorCode::kCorrupt);
    EXPECT_THAT(head.error().message, HasSubstr("is not a thing: take another"));
  }
}

TEST_F(FileReaderTest, ReadsValuesTextsAndVectorsInOrder) {
  writer_.Put(uint32_t{7});
  writer_.PutText("seven");
  writer_.Put(uint64_t{2});
  writer_.Put(0.5f);
  writer_.Put(-1.0f);
  Seal();
  FileReader reader = Open();
  EXPECT_EQ(reader.file_bytes(), bytes_.size());
  EXPECT_EQ(reader.Get<uint32_t>(), 7u);
  EXPECT_EQ(reader.GetText(), "seven");
  EXPECT_THAT(reader.GetVector<float>(), ElementsAre(0.5f, -1.0f));
  EXPECT_TRUE(reader.ok());
  EXPECT_TRUE(reader.CheckEnd("write it again"));
}

TEST_F(FileReaderTest, SaysWhetherLengthsOrBytesAreDamagedAndWhatToDo) {
  writer_.Put(uint64_t{7});
  Seal();
  FileReader unread = Open();
  EXPECT_THAT(unread.CheckEnd("write it again").error().message,
              AllOf(HasSubstr(path_.string()), HasSubstr("lengths"), HasSubstr("write it again")));
  bytes_[0] ^= std::byte{1};
  WritePlainly(path_, bytes_);
  FileReader changed = Open();
  EXPECT_EQ(changed.Get<uint64_t>(), 6u);
  const Status end = changed.CheckEnd("write it again");
  EXPECT_EQ(end.error().code, ErrorCode::kCorrupt);
  EXPECT_THAT(end.error().message, HasSubstr("checksum"));
}

// The largest counts, and those whose product with the size of a value is small again.
TEST_F(FileReaderTest, TakesNoMemoryForWhatIsNotThere) {
  for (const uint64_t count : {UINT64_MAX, UINT64_MAX / 4 + 2, uint64_t{1} << 40, uint64_t{3}}) {
    bytes_.clear();
    writer_.Put(count);
    Seal();
    FileReader reader = Open();
    EXPECT_THAT(reader.GetVector<float>(), IsEmpty()) << count;
    EXPECT_FALSE(reader.ok());
    EXPECT_EQ(reader.Get<uint32_t>(), 0u) << "nothing after it either";
    EXPECT_EQ(reader.CheckEnd("write it again").error().code, ErrorCode::kCorrupt);
  }
}

TEST_F(FileReaderTest, FileThatShrinksWhileItIsReadIsDamaged) {
  writer_.Put(uint64_t{1} << 20);
  bytes_.resize(bytes_.size() + (4 << 20));
  Seal();
  FileReader reader = Open();
  std::filesystem::resize_file(path_, 100);
  EXPECT_EQ(reader.GetVector<float>().size(), size_t{1} << 20);
  EXPECT_EQ(reader.CheckEnd("write it again").error().code, ErrorCode::kCorrupt);
}

TEST_F(FileReaderTest, LongerThanTheBoundIsRefused) {
  Seal();
  EXPECT_EQ(FileReader::Open(path_, 7).error().code, ErrorCode::kExhausted);
  EXPECT_EQ(FileReader::Open(folder_.path() / "none", 7).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace dadrl
