#include "common/io/each_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <string>
#include <vector>

#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<std::string> Lines(const std::filesystem::path& path) {
  std::vector<std::string> lines;
  ForEachLine(path, [&](std::string_view line) { lines.emplace_back(line); });
  return lines;
}

TEST(EachLine, IsSeenOnceInOrderHoweverLongTheFileIs) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "table";
  std::ofstream(file) << "a\n\nlast";
  EXPECT_THAT(Lines(file), ElementsAre("a", "", "last"));
  std::string text;
  for (int i = 0; i < 50000; ++i) text += std::to_string(i) + "\n";
  std::ofstream(file) << text;
  const std::vector<std::string> lines = Lines(file);
  ASSERT_EQ(lines.size(), 50000U);
  EXPECT_EQ(lines[40000], "40000");
}

TEST(EachLine, OfWhatIsNoFileOfOursThereIsNone) {
  const TemporaryFolder folder;
  EXPECT_THAT(Lines(folder.path() / "absent"), IsEmpty());
  ASSERT_EQ(mkfifo((folder.path() / "fifo").c_str(), 0600), 0);
  EXPECT_THAT(Lines(folder.path() / "fifo"), IsEmpty()) << "not waited for";
  std::filesystem::create_symlink("/dev/zero", folder.path() / "link");
  EXPECT_THAT(Lines(folder.path() / "link"), IsEmpty());
}

TEST(EachLine, WithoutAnEndIsNotReadOn) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "table";
  std::ofstream(file) << "a\n" << std::string(2 * kLongestLine, 'x') << "\nb\n";
  EXPECT_THAT(Lines(file), ElementsAre("a"));
}

}  // namespace
}  // namespace dadrl
