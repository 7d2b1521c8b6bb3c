#include "deploy/local/folder_check.h"

#include <gmock/gmock.h>

#include "tests/common/io/small_disk.h"
#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

using testing::HasSubstr;

TEST(CheckFolder, FindsLinksAndLocksAndLeavesNothingBehind) {
  const TemporaryFolder folder;
  const MachineCheck check = CheckFolder(folder.path());
  EXPECT_EQ(check.state, CheckState::kGood) << check.detail;
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(CheckFolder, SaysWhyNothingCanBeWritten) {
  const TemporaryFolder folder;
  EXPECT_THAT(CheckFolder(folder.path() / "absent").detail, HasSubstr("No such file"));
  const SmallDisk disk(folder.path() / "disk", "64k");
  ASSERT_TRUE(disk.mounted()) << disk.why();
  ASSERT_TRUE(disk.MakeReadOnly());
  const MachineCheck check = CheckFolder(disk.path());
  EXPECT_EQ(check.state, CheckState::kWarning);
  EXPECT_THAT(check.detail, HasSubstr("Read-only file system"));
  EXPECT_FALSE(check.remedy.empty());
}

}  // namespace
}  // namespace dadrl
