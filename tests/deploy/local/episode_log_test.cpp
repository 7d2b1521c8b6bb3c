#include "deploy/local/episode_log.h"

#include <gmock/gmock.h>

#include "tests/deploy/local/test_processes.h"

namespace dadrl {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

EpisodeReport Report(uint64_t episode) {
  EpisodeReport report;
  report.scenario = "left_turn";
  report.actor = 2;
  report.episode = episode;
  report.outcome = 1;
  report.episode_return = -0.5;
  report.sent_ns = 1'500'000'000;
  return report;
}

TEST(EpisodeLog, WritesAHeaderOnceAndARowAnEpisode) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "episodes.csv";
  for (uint64_t session = 0; session < 2; ++session) {
    auto log = EpisodeLog::Open(file);
    ASSERT_TRUE(log);
    ASSERT_TRUE(log->Append(Report(10 + session)));
  }
  EXPECT_EQ(
      FileText(file),
      "time_s,actor,episode,seed,outcome,steps,return,progress,mean_speed_mps,humanness_error,overall_score,"
      "policy_version,scenario\n"
      "1.500,2,10,0,collision,0,-0.5,0,0,0,0,0,left_turn\n"
      "1.500,2,11,0,collision,0,-0.5,0,0,0,0,0,left_turn\n");
}

TEST(EpisodeLog, CutsOffHalfARowThatAKilledLauncherLeft) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "episodes.csv";
  std::ofstream(file) << "header\n1,2,3\n4,5";
  ASSERT_TRUE(EpisodeLog::Open(file));
  EXPECT_EQ(FileText(file), "header\n1,2,3\n");
  std::ofstream(file) << "half a head";
  ASSERT_TRUE(EpisodeLog::Open(file));
  EXPECT_THAT(FileText(file), StartsWith("time_s,actor"));
}

TEST(EpisodeLog, NamesTheFileThatCannotBeWritten) {
  const auto log = EpisodeLog::Open("/no/such/folder/episodes.csv");
  ASSERT_FALSE(log);
  EXPECT_THAT(log.error().message, HasSubstr("/no/such/folder/episodes.csv"));
}

}  // namespace
}  // namespace dadrl
