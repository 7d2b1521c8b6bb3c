#include "common/io/guarded_mapping.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <thread>
#include <vector>

#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

const uint64_t kPage = static_cast<uint64_t>(sysconf(_SC_PAGESIZE));

class GuardedMappingTest : public testing::Test {
 protected:
  GuardedMappingTest() { WritePlainly(path_, std::vector<std::byte>(4 * kPage, std::byte{7})); }
  GuardedMapping Map(uint64_t length) const {
    const FileDescriptor file = FileDescriptor::Open(path_, O_RDONLY).value();
    return GuardedMapping::Map(file, length, path_).value();
  }
  static bool AllAre(std::span<const std::byte> bytes, int value) {
    return std::ranges::all_of(bytes, [&](std::byte byte) { return byte == static_cast<std::byte>(value); });
  }

  TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_.path() / "file";
};

TEST_F(GuardedMappingTest, ReadsTheFileWithoutADescriptor) {
  const GuardedMapping mapping = Map(4 * kPage);
  EXPECT_TRUE(AllAre(mapping.bytes(), 7));
  EXPECT_FALSE(mapping.damaged());
}

TEST_F(GuardedMappingTest, WhatIsCutOffReadsAsZerosAndIsToldOfThisMappingAlone) {
  GuardedMapping cut = Map(4 * kPage);
  std::filesystem::resize_file(path_, kPage);
  const auto other_path = folder_.path() / "other";
  WritePlainly(other_path, std::vector<std::byte>(kPage, std::byte{9}));
  const FileDescriptor other_file = FileDescriptor::Open(other_path, O_RDONLY).value();
  const GuardedMapping other = GuardedMapping::Map(other_file, kPage, other_path).value();
  EXPECT_FALSE(cut.damaged()) << "nobody has looked yet";
  EXPECT_TRUE(AllAre(cut.bytes().first(kPage), 7));
  EXPECT_FALSE(cut.damaged()) << "this much is still there";
  EXPECT_TRUE(AllAre(cut.bytes().subspan(kPage), 0));
  EXPECT_TRUE(cut.damaged());
  cut.ForgetDamage();
  EXPECT_TRUE(AllAre(cut.bytes().subspan(kPage), 0));
  EXPECT_FALSE(cut.damaged()) << "the zeros are no news";
  EXPECT_TRUE(AllAre(other.bytes(), 9));
  EXPECT_FALSE(other.damaged());
}

TEST_F(GuardedMappingTest, ManyThreadsMayMeetTheDamageAtOnce) {
  const GuardedMapping mapping = Map(4 * kPage);
  std::filesystem::resize_file(path_, 0);
  std::vector<std::jthread> threads;
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&] { EXPECT_TRUE(AllAre(mapping.bytes(), 0)); });
  }
  threads.clear();
  EXPECT_TRUE(mapping.damaged());
}

TEST_F(GuardedMappingTest, ASlotThatIsUsedAgainStartsSound) {
  for (int round = 0; round < 600; ++round) {
    std::vector<GuardedMapping> some;
    for (int i = 0; i < 3; ++i) some.push_back(Map(kPage));
    ASSERT_TRUE(AllAre(some.back().bytes(), 7));
    ASSERT_FALSE(some.back().damaged());
  }
  GuardedMapping damaged = Map(kPage);
  std::filesystem::resize_file(path_, 0);
  EXPECT_TRUE(AllAre(damaged.bytes(), 0));
  damaged = GuardedMapping();
  EXPECT_FALSE(damaged.damaged());
}

TEST_F(GuardedMappingTest, ABusErrorElsewhereStillEndsTheProcess) {
  const GuardedMapping mapping = Map(kPage);
  // A sanitizer's own handler reports the signal and exits.
  const auto ended = [](int status) {
    return WIFSIGNALED(status) ? WTERMSIG(status) == SIGBUS : status != 0;
  };
  EXPECT_EXIT(
      {
        const FileDescriptor file = FileDescriptor::Open(path_, O_RDONLY).value();
        const auto* const memory =
            static_cast<const volatile char*>(mmap(nullptr, 8 * kPage, PROT_READ, MAP_SHARED, file.get(), 0));
        _exit(memory[7 * kPage]);
      },
      ended, "");
}

}  // namespace
}  // namespace dadrl
