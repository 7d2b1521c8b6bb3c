#include "common/io/file_descriptor.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include "common/io/mapped_file.h"
#include "common/io/read_file.h"
#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

void Put(const fs::path& path, std::string_view text) { WritePlainly(path, std::as_bytes(std::span(text))); }
using testing::HasSubstr;

class OpenTest : public testing::Test {
 protected:
  OpenTest() {
    Put(theirs_, "theirs");
    fs::create_symlink(theirs_, link_);
  }
  TemporaryFolder folder_;
  fs::path theirs_ = folder_.path() / "theirs";
  fs::path link_ = folder_.path() / "link";
};

TEST_F(OpenTest, LinksAreNotFollowedUnlessAUserNamedThem) {
  for (const int flags : {O_RDONLY, O_WRONLY, O_RDWR | O_CREAT, O_RDWR | O_CREAT | O_APPEND}) {
    const auto file = FileDescriptor::Open(link_, flags);
    ASSERT_FALSE(file) << flags;
    EXPECT_EQ(file.error().code, ErrorCode::kInvalidArgument);
    EXPECT_THAT(file.error().message, HasSubstr("is a link, which is not followed"));
  }
  EXPECT_FALSE(ReadTextFile(link_, 100));
  EXPECT_FALSE(MappedFile::Open(link_));
  EXPECT_EQ(ReadTextFile(link_, 100, Links::kFollow).value(), "theirs");
  EXPECT_TRUE(MappedFile::Open(link_, Links::kFollow));
}

TEST_F(OpenTest, ALinkToNothingMakesNoFile) {
  const fs::path nothing = folder_.path() / "nothing";
  fs::create_symlink(nothing, folder_.path() / "dangling");
  EXPECT_FALSE(FileDescriptor::Open(folder_.path() / "dangling", O_RDWR | O_CREAT));
  EXPECT_FALSE(fs::exists(nothing));
}

TEST_F(OpenTest, WhatIsNoFileIsRefusedAtOnceAndUnchanged) {
  const fs::path fifo = folder_.path() / "fifo";
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  for (const int flags : {O_RDONLY, O_WRONLY, O_RDWR | O_CREAT}) {
    const auto file = FileDescriptor::Open(fifo, flags);
    ASSERT_FALSE(file) << flags;
    EXPECT_THAT(file.error().message, HasSubstr("FIFO"));
  }
  EXPECT_THAT(FileDescriptor::Open("/dev/null", O_RDWR).error().message, HasSubstr("is a device"));
  EXPECT_THAT(FileDescriptor::Open(folder_.path(), O_RDONLY).error().message, HasSubstr("is a folder"));
  EXPECT_TRUE(FileDescriptor::Open(folder_.path(), O_RDONLY | O_DIRECTORY));
  EXPECT_EQ(ReadFile("/dev/zero", 100, Links::kFollow).error().code, ErrorCode::kInvalidArgument);
}

TEST_F(OpenTest, ASocketIsRefused) {
  const fs::path path = folder_.path() / "socket";
  sockaddr_un address{.sun_family = AF_UNIX, .sun_path = {}};
  ASSERT_LT(path.string().size(), sizeof address.sun_path);
  path.string().copy(address.sun_path, sizeof address.sun_path - 1);
  const FileDescriptor socket_file(socket(AF_UNIX, SOCK_STREAM, 0));
  ASSERT_EQ(bind(socket_file.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  EXPECT_EQ(FileDescriptor::Open(path, O_RDWR).error().code, ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace dadrl
