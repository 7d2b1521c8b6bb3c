#include "deploy/local/episode_log.h"

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include "tests/deploy/local/test_processes.h"

namespace dadrl {
namespace {

using ::testing::EndsWith;
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

// A child, because the limit on the size of files is its whole process's.
int AppendWithRoomForHalfARow(const std::filesystem::path& file) {
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    auto log = EpisodeLog::Open(file);
    if (!log || !log->Append(Report(1))) _exit(2);
    const rlim_t room = std::filesystem::file_size(file) + 10;
    const rlimit full{room, RLIM_INFINITY};
    const rlimit free{RLIM_INFINITY, RLIM_INFINITY};
    setrlimit(RLIMIT_FSIZE, &full);
    const bool refused = !log->Append(Report(2));
    setrlimit(RLIMIT_FSIZE, &free);
    _exit(refused && log->Append(Report(3)) ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

TEST(EpisodeLog, AFullDiskCostsWholeRowsOnly) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "episodes.csv";
  ASSERT_EQ(AppendWithRoomForHalfARow(file), 0);
  EXPECT_THAT(FileText(file), EndsWith("\n1.500,2,1,0,collision,0,-0.5,0,0,0,0,0,left_turn\n"
                                       "1.500,2,3,0,collision,0,-0.5,0,0,0,0,0,left_turn\n"));
}

TEST(EpisodeLog, NamesTheFileThatCannotBeWritten) {
  const auto log = EpisodeLog::Open("/no/such/folder/episodes.csv");
  ASSERT_FALSE(log);
  EXPECT_THAT(log.error().message, HasSubstr("/no/such/folder/episodes.csv"));
}

}  // namespace
}  // namespace dadrl
