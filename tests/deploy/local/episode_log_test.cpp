#include "deploy/local/episode_log.h"

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include "proto/evaluation/episode_row.h"
#include "tests/deploy/local/test_processes.h"

namespace dadrl {
namespace {

using ::testing::HasSubstr;

constexpr const char* kHeader =
    "time_s,actor,episode,seed,outcome,steps,return,progress,mean_speed_mps,humanness_error,overall_score,"
    "policy_version,scenario\n";

class EpisodeLogTest : public testing::Test {
 protected:
  EpisodeLogTest() { std::filesystem::create_directories(logs_); }

  std::filesystem::path LogOf(int actor) const { return logs_ / fmt::format("episodes-actor-{}.csv", actor); }
  // As the actor does it.
  void Drive(int actor, uint64_t episode, double time_s, const std::string& scenario = "left_turn") const {
    std::ofstream log(LogOf(actor), std::ios::app);
    if (log.tellp() == 0) log << ActorEpisodeColumns() << '\n';
    TrainingEpisode driven{.wall_time_ns = std::llround(1e9 * time_s), .incarnation = 9, .episode = episode};
    driven.summary = {.scenario = scenario, .outcome = Outcome::kCollision, .steps = 40};
    driven.summary.episode_return = -0.5;
    log << ActorEpisodeRow(driven);
  }
  static std::string Row(int actor, uint64_t episode, double time_s,
                         const std::string& scenario = "left_turn") {
    return fmt::format("{:.3f},{},{},0,collision,40,-0.5,0,0,0,0,0,{}\n", time_s, actor, episode, scenario);
  }
  EpisodeLog Open() const {
    auto log = EpisodeLog::Open(table_, logs_);
    EXPECT_TRUE(log) << log.error().message;
    return std::move(*log);
  }

  const TemporaryFolder folder_;
  const std::filesystem::path logs_ = folder_.path() / "logs";
  const std::filesystem::path table_ = folder_.path() / "episodes.csv";
};

TEST_F(EpisodeLogTest, HasEachEpisodeOfEachActorOnceInTheOrderOfTheirTimes) {
  EpisodeLog log = Open();
  ASSERT_TRUE(log.Update());
  EXPECT_EQ(FileText(table_), kHeader);
  Drive(0, 1, 2.0);
  Drive(0, 2, 4.0);
  Drive(12, 1, 3.0);
  ASSERT_TRUE(log.Update());
  ASSERT_TRUE(log.Update());
  Drive(12, 2, 3.5);
  std::ofstream(logs_ / "episodes-actor-x.csv") << ActorEpisodeColumns() << "\nnot an actor's\n";
  ASSERT_TRUE(log.Update());
  EXPECT_EQ(FileText(table_), kHeader + Row(0, 1, 2.0) + Row(12, 1, 3.0) + Row(0, 2, 4.0) + Row(12, 2, 3.5));
  EXPECT_EQ(log.episodes(), 4u);
  EXPECT_EQ(log.env_steps(), 160u);
}

TEST_F(EpisodeLogTest, GoesOnCountingAndTakesOverWhatAKilledLauncherMissed) {
  {
    EpisodeLog log = Open();
    Drive(0, 1, 1.0);
    Drive(1, 1, 2.0);
    ASSERT_TRUE(log.Update());
  }
  Drive(0, 2, 3.0);  // nobody was there
  EpisodeLog log = Open();
  EXPECT_EQ(log.episodes(), 2u);
  Drive(1, 2, 4.0);
  ASSERT_TRUE(log.Update());
  EXPECT_EQ(FileText(table_), kHeader + Row(0, 1, 1.0) + Row(1, 1, 2.0) + Row(0, 2, 3.0) + Row(1, 2, 4.0));
  EXPECT_EQ(log.episodes(), 4u);
  EXPECT_EQ(Open().episodes(), 4u);
}

TEST_F(EpisodeLogTest, NeverTakesHalfARow) {
  EpisodeLog log = Open();
  Drive(0, 1, 1.0);
  const std::string before = FileText(LogOf(0));
  Drive(0, 2, 2.0);
  const std::string whole = FileText(LogOf(0));
  std::ofstream(LogOf(0), std::ios::trunc) << whole.substr(0, whole.size() - 3);
  ASSERT_TRUE(log.Update());
  EXPECT_EQ(FileText(table_), kHeader + Row(0, 1, 1.0));
  // Its actor was killed there; the next one cuts that off.
  std::ofstream(LogOf(0), std::ios::trunc) << before;
  Drive(0, 2, 5.0);
  ASSERT_TRUE(log.Update());
  EXPECT_EQ(FileText(table_), kHeader + Row(0, 1, 1.0) + Row(0, 2, 5.0));
}

TEST_F(EpisodeLogTest, CutsOffHalfARowThatAKilledLauncherLeft) {
  Drive(0, 1, 1.0);
  Drive(0, 2, 2.0);
  std::ofstream(table_) << kHeader + Row(0, 1, 1.0) + Row(0, 2, 2.0).substr(0, 20);
  EpisodeLog log = Open();
  ASSERT_TRUE(log.Update());
  EXPECT_EQ(FileText(table_), kHeader + Row(0, 1, 1.0) + Row(0, 2, 2.0));
}

TEST_F(EpisodeLogTest, CountsOnAfterAnActorWhoseLogBeganAnew) {
  std::ofstream(table_) << kHeader + Row(0, 500, 1.0);
  EpisodeLog log = Open();  // the logs were removed
  Drive(0, 1, 2.0);
  ASSERT_TRUE(log.Update());
  EXPECT_EQ(log.episodes(), 2u);
  EXPECT_EQ(Open().episodes(), 2u);
}

TEST_F(EpisodeLogTest, KeepsAnyNameOfAScenarioInItsCell) {
  EpisodeLog log = Open();
  Drive(0, 1, 1.0, "on ramp");
  Drive(0, 2, 2.0, "Mündung, \"neu\"");
  ASSERT_TRUE(log.Update());
  EXPECT_EQ(FileText(table_),
            kHeader + Row(0, 1, 1.0, "on ramp") + Row(0, 2, 2.0, "\"Mündung, \"\"neu\"\"\""));
  EXPECT_EQ(Open().episodes(), 2u);
}

TEST_F(EpisodeLogTest, LeavesTheLogOfAnotherVersionAlone) {
  std::ofstream(LogOf(0)) << "time_s,episode\n1.000,1\n";
  EpisodeLog log = Open();
  ASSERT_TRUE(log.Update());
  std::filesystem::rename(LogOf(0), LogOf(0).string() + ".old");  // as its actor does
  Drive(0, 1, 1.0);
  ASSERT_TRUE(log.Update());
  EXPECT_EQ(FileText(table_), kHeader + Row(0, 1, 1.0));
}

// A child, because the limit on the size of files is its whole process's.
TEST_F(EpisodeLogTest, AFullDiskCostsNoRow) {
  EpisodeLog log = Open();
  Drive(0, 1, 1.0);
  Drive(0, 2, 2.0);
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit full{std::filesystem::file_size(table_) + 10, RLIM_INFINITY};
    const rlimit free{RLIM_INFINITY, RLIM_INFINITY};
    setrlimit(RLIMIT_FSIZE, &full);
    const bool refused = !log.Update() && log.episodes() == 0;
    setrlimit(RLIMIT_FSIZE, &free);
    _exit(refused && log.Update() && log.episodes() == 2 ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(FileText(table_), kHeader + Row(0, 1, 1.0) + Row(0, 2, 2.0));
}

TEST_F(EpisodeLogTest, NamesTheFileThatCannotBeWritten) {
  std::ofstream(folder_.path() / "file").flush();
  const auto log = EpisodeLog::Open(folder_.path() / "file" / "episodes.csv", logs_);
  ASSERT_FALSE(log);
  EXPECT_THAT(log.error().message, HasSubstr((folder_.path() / "file").string()));
}

}  // namespace
}  // namespace dadrl
