#include "learner/version_reserve.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/io/atomic_file.h"
#include "tests/common/io/small_disk.h"
#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

TEST(VersionReserve, AProcessThatIsKilledNeverUsesAVersionTwice) {
  TemporaryFolder folder;
  uint32_t used = 0;
  for (int restart = 0; restart < 5; ++restart) {
    VersionReserve reserve = VersionReserve::Open(folder.path()).value();
    EXPECT_GE(reserve.highest(), used);
    for (int i = 0; i < 7 * restart; ++i) {
      const uint32_t version = std::max(used, restart > 0 && i == 0 ? reserve.highest() : used) + 1;
      EXPECT_GT(version, used);
      ASSERT_TRUE(reserve.Use(version));
      EXPECT_GE(VersionReserve::Open(folder.path())->highest(), version);
      used = version;
    }
  }
}

TEST(VersionReserve, AFullDiskKeepsTheNumbersApartOneThatTakesNoWritesKeepsThemIn) {
  TemporaryFolder folder;
  const SmallDisk disk(folder.path() / "disk", "64k");
  ASSERT_TRUE(disk.mounted()) << disk.why();
  VersionReserve reserve = VersionReserve::Open(disk.path()).value();
  ASSERT_TRUE(reserve.Use(1));
  disk.Fill();
  for (uint32_t version = 2; version < 100; ++version) {
    ASSERT_TRUE(reserve.Use(version));
    ASSERT_GE(VersionReserve::Open(disk.path())->highest(), version) << "a killed learner would use it again";
  }
  ASSERT_TRUE(disk.MakeReadOnly());
  EXPECT_TRUE(reserve.Use(reserve.highest())) << "it is reserved";
  EXPECT_FALSE(reserve.Use(reserve.highest() + 1));
}

TEST(VersionReserve, GarbageIsCorruptWithTheRemedy) {
  TemporaryFolder folder;
  ASSERT_TRUE(WriteFileAtomically(folder.path() / "weights_version", "12x\n"));
  const auto reserve = VersionReserve::Open(folder.path());
  ASSERT_FALSE(reserve);
  EXPECT_EQ(reserve.error().code, ErrorCode::kCorrupt);
  EXPECT_THAT(reserve.error().message, testing::HasSubstr((folder.path() / "weights_version").string()));
}

}  // namespace
}  // namespace dadrl
