#include "deploy/local/selection_job.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <map>
#include <set>

#include "tests/deploy/local/saved_policies.h"
#include "tests/deploy/local/test_processes.h"

namespace dadrl {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// What is started is a script that speaks dadrl-actor's protocol: it logs policy and seed, and prints the
// line prepared for a success or for a collision.
class SelectionJobTest : public testing::Test {
 protected:
  static constexpr int kEpisodes = 6;

  SelectionJobTest() {
    for (int i = 0; i < kEpisodes; ++i) {
      EvaluatedEpisode episode;
      episode.summary.seed = kFirstValidationSeed + static_cast<uint64_t>(i);
      for (const Outcome outcome : {Outcome::kSuccess, Outcome::kCollision}) {
        episode.summary.outcome = outcome;
        const std::string name = fmt::format("{}-{}", OutcomeName(outcome), episode.summary.seed);
        std::ofstream(folder_.path() / name) << EpisodeLine(episode) << "\n";
      }
    }
  }

  // `body` says how $policy (a file's name) does on $seed: it prints a line of $folder.
  SelectionJob MakeJob(const std::string& body, std::vector<uint64_t> updates, int processes = 2) {
    const auto file = folder_.path() / "driver";
    std::ofstream(file) << "#!/bin/sh\nfolder=" << folder_.path().string()
                        << "\npolicy=${3##*/}\nseed=${7%%:*}\nlast=$((seed + ${7##*:}))\n"
                           "while [ $seed -lt $last ]; do\necho $policy $seed >> $folder/driven\n"
                        << body << "\nseed=$((seed + 1))\ndone\n";
    chmod(file.c_str(), 0755);
    SelectionPlan plan{.program = file,
                       .scenario = "left_turn",
                       .config = {},
                       .episodes = kEpisodes,
                       .processes = processes,
                       .candidates = {}};
    for (const uint64_t each : updates) plan.candidates.push_back(SavePolicyAt({folder_.path()}, each));
    auto job = SelectionJob::Create(std::move(plan));
    EXPECT_TRUE(job) << job.error().message;
    return std::move(*job);
  }

  static Result<Selection> RunToEnd(SelectionJob& job) {
    EXPECT_TRUE(Eventually([&] {
      job.Step();
      return job.done();
    }));
    return job.TakeSelection();
  }

  const TemporaryFolder folder_;
};

TEST_F(SelectionJobTest, ChoosesTheCandidateThatSucceedsMostOften) {
  SelectionJob job = MakeJob(
      "outcome=collision; [ $policy = policy-000000020.dadrl ] && outcome=success; cat "
      "$folder/$outcome-$seed",
      {30, 20, 10});
  EXPECT_EQ(job.planned_episodes(), 3 * kEpisodes);
  EXPECT_EQ(job.finished_episodes(), 0);
  const auto selection = RunToEnd(job);
  ASSERT_TRUE(selection) << selection.error().message;
  EXPECT_EQ(job.finished_episodes(), 3 * kEpisodes);
  EXPECT_EQ(selection->chosen().policy.updates, 20u);
  ASSERT_EQ(selection->candidates.size(), 3u);
  EXPECT_EQ(selection->candidates[0].policy.updates, 30u);
  EXPECT_EQ(selection->candidates[0].report.all.collision, 1.0);
  EXPECT_EQ(selection->candidates[1].report.all.success, 1.0);
}

TEST_F(SelectionJobTest, EveryCandidateDrivesTheSameTrafficAndNoneThatGrades) {
  SelectionJob job = MakeJob("cat $folder/success-$seed", {30, 20});
  ASSERT_TRUE(RunToEnd(job));
  std::map<std::string, std::set<uint64_t>> seeds;
  std::ifstream driven(folder_.path() / "driven");
  std::string policy;
  for (uint64_t seed = 0; driven >> policy >> seed;) seeds[policy].insert(seed);
  ASSERT_EQ(seeds.size(), 2u);
  const std::set<uint64_t>& one = seeds.begin()->second;
  EXPECT_EQ(one, seeds.rbegin()->second);
  EXPECT_EQ(one.size(), static_cast<size_t>(kEpisodes));
  const auto graded = PlanEpisodes(kFirstEvaluationSeed, 1000, 1000);  // the most that a user can ask for
  ASSERT_TRUE(graded);
  EXPECT_GT(*one.begin(), graded->back().seed);
}

TEST_F(SelectionJobTest, EndsWithTheErrorOfACandidateThatCannotDrive) {
  SelectionJob job = MakeJob(
      "[ $policy = policy-000000020.dadrl ] && { echo out of luck >&2; exit 1; }; cat $folder/success-$seed",
      {30, 20, 10}, 1);
  const auto selection = RunToEnd(job);
  ASSERT_FALSE(selection);
  EXPECT_THAT(selection.error().message, AllOf(HasSubstr("seed 2000000"), HasSubstr("out of luck")));
  EXPECT_TRUE(job.RunningPids().empty());
  EXPECT_THAT(FileText(folder_.path() / "driven"), Not(HasSubstr("policy-000000010")));
}

TEST_F(SelectionJobTest, RefusesMoreEpisodesThanASeedGroupHolds) {
  const auto job = SelectionJob::Create({.program = "x",
                                         .scenario = "left_turn",
                                         .config = {},
                                         .episodes = 1001,
                                         .processes = 1,
                                         .candidates = {SavePolicyAt({folder_.path()}, 10)}});
  ASSERT_FALSE(job);
  EXPECT_EQ(ExitCode(job.error()), 2);
}

}  // namespace
}  // namespace dadrl
