#include "common/io/run_key.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

TEST(RunKey, IsDrawnOnceForItsOwnerAlone) {
  const TemporaryFolder run;
  const std::string key = EnsureRunKey(run.path()).value();
  EXPECT_EQ(key.size(), 32);
  EXPECT_EQ(EnsureRunKey(run.path()).value(), key);
  EXPECT_EQ(ReadRunKey(RunKeyFile(run.path())).value(), key);
  struct stat info {};
  ASSERT_EQ(stat(RunKeyFile(run.path()).c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0600);
  const TemporaryFolder other;
  EXPECT_NE(EnsureRunKey(other.path()).value(), key);
}

TEST(RunKey, OfAJoinedRunIsThatOfTheRun) {
  const TemporaryFolder run;
  const std::string key(32, 'f');
  ASSERT_TRUE(SaveRunKey(run.path(), key));
  EXPECT_EQ(EnsureRunKey(run.path()).value(), key);
}

TEST(RunKey, OutlivesALauncherThatWasKilledWhileItWrote) {
  const TemporaryFolder run;
  std::ofstream(RunKeyFile(run.path()).string() + ".new") << "half";
  EXPECT_EQ(EnsureRunKey(run.path()).value().size(), 32);
}

TEST(RunKey, RefusesWhatIsNone) {
  const TemporaryFolder run;
  const auto file = RunKeyFile(run.path());
  EXPECT_EQ(ReadRunKey(file).error().code, ErrorCode::kNotFound);
  for (const std::string& text : {std::string(), std::string(31, 'a'), std::string(33, 'a'),
                                  std::string(32, 'x'), std::string(5000, 'a')}) {
    std::ofstream(file) << text;
    EXPECT_EQ(EnsureRunKey(run.path()).error().code, ErrorCode::kCorrupt) << text.size();
  }
}

TEST(RunKey, FollowsNoLink) {
  const TemporaryFolder run;
  const auto elsewhere = run.path() / "elsewhere";
  std::ofstream(elsewhere) << std::string(32, 'a');
  std::filesystem::create_symlink(elsewhere, RunKeyFile(run.path()));
  EXPECT_FALSE(EnsureRunKey(run.path()));
}

}  // namespace
}  // namespace dadrl
