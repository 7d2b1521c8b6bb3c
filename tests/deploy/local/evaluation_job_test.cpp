#include "deploy/local/evaluation_job.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <cstdlib>
#include <set>

#include "tests/deploy/local/test_processes.h"

namespace dadrl {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(SliceEpisodes, CutsGroupsIntoConsecutiveSeedsOfSimilarSize) {
  const auto plan = PlanEpisodes(1'000'000, 2, 5);
  ASSERT_TRUE(plan);
  EXPECT_THAT(SliceEpisodes(*plan, 1),
              ElementsAre(EvaluationSlice{0, 1'000'000, 3}, EvaluationSlice{0, 1'000'003, 2},
                          EvaluationSlice{1, 1'001'000, 3}, EvaluationSlice{1, 1'001'003, 2}));
  int total = 0;
  for (const EvaluationSlice& slice : SliceEpisodes(*PlanEpisodes(1'000'000, 5, 50), 2)) total += slice.count;
  EXPECT_EQ(total, 250);
}

// The subject is the gathering process, so what it starts is a script that speaks dadrl-actor's protocol: it
// prints prepared lines, `line-SEED`, for the seeds it is given.
class EvaluationJobTest : public testing::Test {
 protected:
  // `body` runs for each seed in $seed.
  std::filesystem::path Driver(const std::string& body) {
    const auto file = folder_.path() / "driver";
    std::ofstream(file) << "#!/bin/sh\nfolder=" << folder_.path().string()
                        << "\nseeds=$7\nseed=${seeds%%:*}\nlast=$((seed + ${seeds##*:}))\n"
                           "while [ $seed -lt $last ]; do\n"
                        << body << "\nseed=$((seed + 1))\ndone\n";
    chmod(file.c_str(), 0755);
    return file;
  }

  EvaluationJob MakeJob(const std::string& body, int groups, int episodes, int processes,
                        const std::string& scenario = "left_turn",
                        std::function<void(const std::string&)> notice = {}) {
    for (int group = 0; group < groups; ++group) {
      for (int i = 0; i < episodes; ++i) {
        EvaluatedEpisode episode;
        episode.summary.seed = kFirstEvaluationSeed + static_cast<uint64_t>(1000 * group + i);
        episode.summary.outcome = i % 4 == 0 ? Outcome::kCollision : Outcome::kSuccess;
        std::ofstream(folder_.path() / ("line-" + std::to_string(episode.summary.seed)))
            << EpisodeLine(episode) << "\n";
      }
    }
    auto job = EvaluationJob::Create({.program = Driver(body),
                                      .policy = "rdm",
                                      .policy_label = "rdm",
                                      .scenario = scenario,
                                      .config = {},
                                      .groups = groups,
                                      .episodes = episodes,
                                      .processes = processes,
                                      .hang_limits = {.silent = std::chrono::milliseconds(500)},
                                      .notice = std::move(notice)});
    EXPECT_TRUE(job);
    return std::move(*job);
  }

  static bool RunToEnd(EvaluationJob& job) {
    return Eventually([&] {
      job.Step();
      return job.done();
    });
  }

  TemporaryFolder folder_;
};

TEST_F(EvaluationJobTest, GathersEveryEpisodeOnce) {
  EvaluationJob job = MakeJob("cat $folder/line-$seed", 3, 8, 4);
  ASSERT_TRUE(RunToEnd(job));
  EXPECT_EQ(job.finished_episodes(), 24);
  const auto report = job.TakeReport();
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->all.episodes, 24);
  EXPECT_DOUBLE_EQ(report->all.success, 0.75);
  ASSERT_EQ(report->per_seed.size(), 3u);
  EXPECT_EQ(report->per_seed[2].first_seed, 1'002'000u);
  std::set<uint64_t> seeds;
  for (const EvaluatedEpisode& episode : report->episodes) seeds.insert(episode.summary.seed);
  EXPECT_EQ(seeds.size(), 24u);
}

TEST_F(EvaluationJobTest, DrivesEveryEpisodeInEachScenarioOfAll) {
  for (const char* scenario : {"merge", "turn"}) {
    std::filesystem::create_directories(folder_.path() / "scenarios" / scenario);
    std::ofstream(folder_.path() / "scenarios" / scenario / "scenario.yaml") << "warm_up_s: 1\n";
  }
  setenv("DADRL_SCENARIOS", (folder_.path() / "scenarios").c_str(), 1);
  EvaluationJob job = MakeJob("echo $5 >> $folder/driven; cat $folder/line-$seed", 2, 4, 2, "all");
  unsetenv("DADRL_SCENARIOS");
  EXPECT_EQ(job.planned_episodes(), 16);
  ASSERT_TRUE(RunToEnd(job));
  const auto report = job.TakeReport();
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->scenario, "all");
  EXPECT_EQ(report->all.episodes, 16);
  ASSERT_EQ(report->per_scenario.size(), 2u);
  EXPECT_EQ(report->per_scenario[0].scenario, "merge");
  EXPECT_EQ(report->per_scenario[1].figures.episodes, 8);
  const std::string driven = FileText(folder_.path() / "driven");
  EXPECT_THAT(driven, HasSubstr("turn\n"));
  EXPECT_THAT(driven, HasSubstr("merge\n"));
}

TEST_F(EvaluationJobTest, AWorkerThatPrintsWithoutEndIsEnded) {
  EvaluationJob job = MakeJob("yes", 1, 2, 1);
  ASSERT_TRUE(RunToEnd(job));
  EXPECT_TRUE(job.RunningPids().empty());
  EXPECT_THAT(job.TakeReport().error().message, HasSubstr("printed more than 67108864 bytes"));
}

TEST_F(EvaluationJobTest, NeverRunsMoreProcessesThanAsked) {
  EvaluationJob job = MakeJob("sleep 0.02; cat $folder/line-$seed", 1, 12, 3);
  size_t most = 0;
  ASSERT_TRUE(Eventually([&] {
    job.Step();
    most = std::max(most, job.RunningPids().size());
    return job.done();
  }));
  EXPECT_EQ(most, 3u);  // and no fewer where there is work for them
}

TEST_F(EvaluationJobTest, GivesTheRestOfADeadProcessToAnother) {
  EvaluationJob job = MakeJob(
      "cat $folder/line-$seed; if [ $seed = 1000001 ] && [ ! -e $folder/died ]; then : > $folder/died; kill "
      "-9 $$; fi",
      1, 6, 1);
  ASSERT_TRUE(RunToEnd(job));
  const auto report = job.TakeReport();
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "died"));
  EXPECT_EQ(report->all.episodes, 6);
}

TEST_F(EvaluationJobTest, LosesTheEpisodeThatKillsItsProcessTwiceAndNoOther) {
  EvaluationJob job = MakeJob(
      "[ $seed = 1000002 ] && { echo $seed >> $folder/tries; kill -6 $$; }; cat $folder/line-$seed", 1, 6, 1);
  ASSERT_TRUE(RunToEnd(job));
  const auto report = job.TakeReport();
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->all.episodes, 5);
  ASSERT_EQ(report->lost, 1);
  EXPECT_EQ(report->episodes[2].summary.seed, 1'000'002u);
  EXPECT_THAT(report->episodes[2].error, HasSubstr("signal 6"));
  EXPECT_EQ(FileText(folder_.path() / "tries"), "1000002\n1000002\n");
}

TEST_F(EvaluationJobTest, KillsAProcessThatHangsAndDrivesItsEpisodesAgain) {
  std::vector<std::string> notices;
  EvaluationJob job = MakeJob(
      "if [ $seed = 1000001 ] && [ ! -e $folder/hung ]; then : > $folder/hung; kill -STOP $$; fi; "
      "cat $folder/line-$seed",
      1, 6, 1, "left_turn", [&](const std::string& text) { notices.push_back(text); });
  ASSERT_TRUE(RunToEnd(job));
  const auto report = job.TakeReport();
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->all.episodes, 6);
  EXPECT_EQ(report->lost, 0);
  ASSERT_EQ(notices.size(), 1u);
  EXPECT_THAT(notices[0], HasSubstr("hangs: it is stopped by a signal; it is killed"));
}

TEST_F(EvaluationJobTest, LosesTheEpisodeInWhichItHangsTwice) {
  EvaluationJob job = MakeJob("[ $seed = 1000002 ] && kill -STOP $$; cat $folder/line-$seed", 1, 6, 1);
  ASSERT_TRUE(RunToEnd(job));
  const auto report = job.TakeReport();
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->all.episodes, 5);
  ASSERT_EQ(report->lost, 1);
  EXPECT_THAT(report->episodes[2].error, HasSubstr("hung: it is stopped by a signal"));
}

TEST_F(EvaluationJobTest, FailsWithTheLogOfAProcessThatDiesTwice) {
  EvaluationJob job =
      MakeJob("[ $seed = 1000003 ] && { echo out of luck >&2; exit 1; }; cat $folder/line-$seed", 1, 6, 2);
  ASSERT_TRUE(RunToEnd(job));
  const auto report = job.TakeReport();
  ASSERT_FALSE(report);
  EXPECT_THAT(report.error().message, HasSubstr("seed 1000003 (exit code 1)"));
  EXPECT_THAT(report.error().message, HasSubstr("out of luck"));
  EXPECT_TRUE(job.RunningPids().empty());
}

TEST_F(EvaluationJobTest, PassesOnARefusalAsOneLineOfWrongUsage) {
  EvaluationJob job =
      MakeJob("echo '2026-01-01 00:00:00.000 E evaluation: unknown policy rmd' >&2; exit 2", 1, 2, 1);
  ASSERT_TRUE(RunToEnd(job));
  const auto report = job.TakeReport();
  ASSERT_FALSE(report);
  EXPECT_EQ(ExitCode(report.error()), 2);
  EXPECT_EQ(report.error().message, "unknown policy rmd");
}

TEST_F(EvaluationJobTest, RefusesOutputThatIsNotItsEpisodes) {
  EvaluationJob job = MakeJob("echo '{\"seed\": 7}'", 1, 2, 1);
  ASSERT_TRUE(RunToEnd(job));
  EXPECT_FALSE(job.TakeReport());
}

TEST_F(EvaluationJobTest, RefusesTrainingSeeds) {
  const auto job = EvaluationJob::Create({.program = "x",
                                          .policy = "rdm",
                                          .policy_label = "rdm",
                                          .scenario = "left_turn",
                                          .config = {},
                                          .first_seed = 999'999});
  ASSERT_FALSE(job);
  EXPECT_EQ(ExitCode(job.error()), 2);
}

TEST_F(EvaluationJobTest, TakesItsProcessesAlongWhenDropped) {
  std::vector<pid_t> pids;
  {
    EvaluationJob job = MakeJob("sleep 1000", 1, 2, 2);
    job.Step();
    pids = job.RunningPids();
    ASSERT_EQ(pids.size(), 2u);
  }
  for (const pid_t pid : pids) EXPECT_TRUE(IsDead(pid));
}

}  // namespace
}  // namespace dadrl
