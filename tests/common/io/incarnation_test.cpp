#include "common/io/incarnation.h"

#include <gtest/gtest.h>

#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

TEST(NextIncarnation, IsTheTimeOfTheStart) {
  TemporaryFolder run;
  EXPECT_EQ(NextIncarnation(run.path(), "actor-0", 1000), 1000u);
  EXPECT_EQ(NextIncarnation(run.path(), "actor-0", 2000), 2000u);
}

TEST(NextIncarnation, GrowsAlsoWhenTheClockWasSetBack) {
  TemporaryFolder run;
  EXPECT_EQ(NextIncarnation(run.path(), "actor-0", 2000), 2000u);
  EXPECT_EQ(NextIncarnation(run.path(), "actor-0", 1000), 2001u);
  EXPECT_EQ(NextIncarnation(run.path(), "actor-0", 1000), 2002u);
  EXPECT_EQ(NextIncarnation(run.path(), "actor-1", 1000), 1000u) << "each has its own";
}

TEST(NextIncarnation, WithoutWhatWasKeptTheClockCounts) {
  TemporaryFolder run;
  std::filesystem::create_directories(run.path() / "incarnations");
  std::ofstream(run.path() / "incarnations" / "learner") << "no number";
  EXPECT_EQ(NextIncarnation(run.path(), "learner", 1000), 1000u);
  std::ofstream(run.path() / "file") << "not a folder";
  EXPECT_EQ(NextIncarnation(run.path() / "file", "learner", 1000), 1000u);
}

}  // namespace
}  // namespace dadrl
