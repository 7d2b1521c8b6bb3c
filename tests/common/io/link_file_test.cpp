#include "common/io/link_file.h"

#include <gmock/gmock.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <iterator>

#include "common/io/atomic_file.h"
#include "common/io/read_file.h"
#include "tests/common/io/temporary_folder.h"

namespace {

bool file_system_has_symlinks = true;

}  // namespace

// Stands in for the system's: a file system without symbolic links, when told so.
extern "C" int symlink(const char* target, const char* link) {
  if (file_system_has_symlinks) return static_cast<int>(syscall(SYS_symlink, target, link));
  errno = EPERM;
  return -1;
}

namespace dadrl {
namespace {

namespace fs = std::filesystem;

class LinkFile : public testing::TestWithParam<bool> {
 protected:
  LinkFile() {
    file_system_has_symlinks = GetParam();
    for (const char* name : {"one", "two"}) EXPECT_TRUE(WriteFileAtomically(folder_.path() / name, name));
  }
  ~LinkFile() override { file_system_has_symlinks = true; }
  std::string Read(const fs::path& path) const {
    return ReadTextFile(FollowLinks(path), 100, Links::kFollow).value_or("none");
  }

  TemporaryFolder folder_;
  const fs::path link_ = folder_.path() / "latest";
};

INSTANTIATE_TEST_SUITE_P(WithAndWithoutSymlinks, LinkFile, testing::Bool());

TEST_P(LinkFile, NamesTheNewestTarget) {
  for (const char* name : {"one", "two", "one"}) {
    ASSERT_TRUE(LinkAtomically(link_, name));
    EXPECT_EQ(Read(link_), name);
    EXPECT_EQ(fs::is_symlink(link_), GetParam());
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), {}), 3) << "nothing is left behind";
}

TEST_P(LinkFile, ReplacesTheOtherWayToNameIt) {
  ASSERT_TRUE(LinkAtomically(link_, "one"));
  file_system_has_symlinks = !GetParam();
  ASSERT_TRUE(LinkAtomically(link_, "two"));
  EXPECT_EQ(Read(link_), "two");
  EXPECT_EQ(fs::is_symlink(link_), !GetParam());
}

TEST_P(LinkFile, IsFollowedInTheMiddleOfAPathToo) {
  fs::create_directories(folder_.path() / "run" / "checkpoints");
  ASSERT_TRUE(WriteFileAtomically(folder_.path() / "run" / "checkpoints" / "policy", "p"));
  ASSERT_TRUE(LinkAtomically(link_, "run"));
  ASSERT_TRUE(LinkAtomically(folder_.path() / "run" / "checkpoints" / "best", "policy"));
  EXPECT_EQ(Read(link_ / "checkpoints" / "best"), "p");
}

TEST_P(LinkFile, LeavesWhatIsNoLinkAlone) {
  EXPECT_EQ(LinkAtomically(folder_.path() / "one", "two").error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(Read(folder_.path() / "one"), "one");
  fs::create_directory(link_);
  EXPECT_FALSE(LinkAtomically(link_, "two"));
  EXPECT_TRUE(fs::is_directory(link_));
  EXPECT_EQ(FollowLinks(folder_.path() / "absent" / "x"), folder_.path() / "absent" / "x");
}

TEST(FollowLinks, NeverLeavesTheFolder) {
  TemporaryFolder folder;
  const fs::path link = folder.path() / "latest";
  for (const char* content : {"dadrl link: ../x\n", "dadrl link: /etc/passwd\n", "dadrl link: ..\n",
                              "dadrl link: \n", "dadrl link: x", "x\n"}) {
    ASSERT_TRUE(WriteFileAtomically(link, content));
    EXPECT_EQ(FollowLinks(link), link) << content;
  }
}

}  // namespace
}  // namespace dadrl
