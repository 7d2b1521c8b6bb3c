#include "common/io/row_file.h"

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "common/io/read_file.h"
#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

class RowFileTest : public testing::Test {
 protected:
  std::string Text() const { return TextOf(path_); }
  static std::string TextOf(const std::filesystem::path& path) {
    return ReadTextFile(path, uint64_t{1} << 24).value();
  }
  void Write(const std::string& text) const { std::ofstream(path_, std::ios::trunc) << text; }

  const TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_.path() / "table.csv";
};

TEST_F(RowFileTest, StartsWithTheHeaderAndGoesOnBehindTheLastRow) {
  EXPECT_EQ(RowFile::Open(path_, "a,b")->last_row(), "");
  EXPECT_EQ(RowFile::Open(path_, "a,b")->last_row(), "");
  ASSERT_TRUE(RowFile::Open(path_, "a,b")->Append("1,2\n3,4\n"));
  auto again = RowFile::Open(path_, "a,b");
  EXPECT_EQ(again->last_row(), "3,4");
  ASSERT_TRUE(again->Append("5,6\n"));
  EXPECT_EQ(Text(), "a,b\n1,2\n3,4\n5,6\n");
}

TEST_F(RowFileTest, CutsOffHalfARow) {
  for (const size_t length : {size_t{1}, size_t{4095}, size_t{4096}, size_t{10000}}) {
    Write("a,b\n1,2\n" + std::string(length, '3'));
    EXPECT_EQ(RowFile::Open(path_, "a,b")->last_row(), "1,2");
    EXPECT_EQ(Text(), "a,b\n1,2\n");
  }
  Write("a,");
  ASSERT_TRUE(RowFile::Open(path_, "a,b"));
  EXPECT_EQ(Text(), "a,b\n");
}

TEST_F(RowFileTest, KeepsAnotherTableUnderAnotherName) {
  Write("x\n1\n");
  ASSERT_TRUE(RowFile::Open(path_, "a,b"));
  EXPECT_EQ(Text(), "a,b\n");
  EXPECT_EQ(TextOf(path_.string() + ".old"), "x\n1\n");
}

// A child, because the limit on the size of files is its whole process's.
TEST_F(RowFileTest, AFullDiskCostsWholeRowsOnly) {
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    auto table = RowFile::Open(path_, "a,b");
    if (!table || !table->Append("1,2\n")) _exit(2);
    const rlimit full{std::filesystem::file_size(path_) + 2, RLIM_INFINITY};
    const rlimit free{RLIM_INFINITY, RLIM_INFINITY};
    setrlimit(RLIMIT_FSIZE, &full);
    const bool refused = !table->Append("3,4\n");
    setrlimit(RLIMIT_FSIZE, &free);
    _exit(refused && table->Append("5,6\n") ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_EQ(status, 0);
  EXPECT_EQ(Text(), "a,b\n1,2\n5,6\n");
}

TEST_F(RowFileTest, NamesTheFileThatCannotBeWritten) {
  Write("a file where the folder should be");
  const auto table = RowFile::Open(path_ / "table.csv", "a");
  ASSERT_FALSE(table);
  EXPECT_THAT(table.error().message, testing::HasSubstr(path_.string()));
}

}  // namespace
}  // namespace dadrl
