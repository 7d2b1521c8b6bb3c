#include "common/io/number_file.h"

#include <gtest/gtest.h>

#include "common/io/atomic_file.h"
#include "tests/common/io/small_disk.h"
#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

constexpr uint64_t kLargest = ~uint64_t{0};

TEST(NumberFile, KeepsTheLastNumber) {
  TemporaryFolder folder;
  const auto path = folder.path() / "number";
  EXPECT_EQ(ReadNumber(path).error().code, ErrorCode::kNotFound);
  for (const uint64_t number : {uint64_t{0}, kLargest, uint64_t{17}}) {
    ASSERT_TRUE(WriteNumber(path, number));
    EXPECT_EQ(ReadNumber(path), number);
  }
  ASSERT_TRUE(WriteFileAtomically(path, "123\n"));
  EXPECT_EQ(ReadNumber(path), 123u) << "as earlier versions wrote it";
  for (const char* bad : {"", "12", "12x\n", "x\n", "123456789012345678901234567890\n"}) {
    ASSERT_TRUE(WriteFileAtomically(path, bad));
    EXPECT_EQ(ReadNumber(path).error().code, ErrorCode::kCorrupt) << bad;
  }
}

TEST(NumberFile, NeedsNoRoomForTheNextNumber) {
  TemporaryFolder folder;
  const SmallDisk disk(folder.path() / "disk", "64k");
  ASSERT_TRUE(disk.mounted()) << disk.why();
  const auto path = disk.path() / "number";
  ASSERT_TRUE(WriteFileAtomically(path, "7\n"));
  disk.Fill();
  ASSERT_FALSE(WriteFileAtomically(disk.path() / "another", "8\n"));
  for (const uint64_t number : {uint64_t{8}, kLargest, uint64_t{9}}) {
    EXPECT_TRUE(WriteNumber(path, number));
    EXPECT_EQ(ReadNumber(path), number);
  }
  EXPECT_FALSE(WriteNumber(disk.path() / "new", 1)) << "a first number needs room";
}

}  // namespace
}  // namespace dadrl
