#include "actor/evaluation/evaluation.h"

#include <gtest/gtest.h>
#include <libsumo/libsumo.h>

#include <string>
#include <utility>
#include <vector>

#include "actor/policies/learned_policy.h"
#include "actor/sim/traffic.h"
#include "tests/common/model/counting_policy.h"

namespace dadrl {
namespace {

EvaluationOptions Options(const std::string& policy, int groups, int episodes) {
  EvaluationOptions options;
  options.config.scenario = "left_turn";
  options.policy = policy;
  options.episodes = *PlanEpisodes(kFirstEvaluationSeed, groups, episodes);
  return options;
}

TEST(RunEvaluation, DrivesEveryPlannedEpisodeOnceAndReportsIt) {
  EvaluationOptions options = Options("rdm", 2, 3);
  std::vector<PlannedEpisode> seen;
  options.on_episode = [&](const EvaluatedEpisode& episode) {
    seen.push_back({episode.group, episode.summary.seed});
    return true;
  };
  const auto report = RunEvaluation(options);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(seen, options.episodes);
  EXPECT_EQ(report->all.episodes, 6);
  EXPECT_EQ(report->lost, 0);
  EXPECT_EQ(report->per_seed.size(), 2U);
  EXPECT_NEAR(report->all.success + report->all.collision + report->all.off_road + report->all.stagnation,
              1.0, 1e-12);
  EXPECT_EQ(report->scenario, "left_turn");
}

TEST(RunEvaluation, SplitOverWorkersItIsTheSameReport) {
  for (const char* policy : {"random", "predictive"}) {
    const EvaluationOptions whole = Options(policy, 1, 4);
    const auto reference = RunEvaluation(whole);
    ASSERT_TRUE(reference);
    std::vector<EvaluatedEpisode> gathered;
    for (int worker = 0; worker < 2; ++worker) {
      EvaluationOptions part = whole;
      part.episodes = EpisodesOfWorker(whole.episodes, worker, 2);
      const auto report = RunEvaluation(part);
      ASSERT_TRUE(report);
      for (const EvaluatedEpisode& episode : report->episodes) {
        gathered.push_back(*ParseEpisodeLine(EpisodeLine(episode)));
      }
    }
    EXPECT_EQ(ReportJson(MakeReport("left_turn", policy, gathered)), ReportJson(*reference));
  }
}

// Takes the ego out of SUMO in one of its episodes.
class SabotagedPolicy final : public DrivingPolicy {
 public:
  explicit SabotagedPolicy(uint64_t seed) : sabotaged_seed_(seed) {}
  void BeginEpisode(uint64_t seed) override { sabotage_ = seed == sabotaged_seed_; }
  Decision Decide(const DrivingEnvironment&) override {
    if (std::exchange(sabotage_, false)) libsumo::Vehicle::remove(kEgoId);
    return {{15.0, 0}, 1};
  }

 private:
  uint64_t sabotaged_seed_;
  bool sabotage_ = false;
};

TEST(DriveEpisodes, ALearnedPolicyWithAMemoryForgetsBetweenEpisodes) {
  EvaluationOptions options = Options("rdm", 1, 2);
  options.config.task.max_steps = 30;
  const auto environment = DrivingEnvironment::Create(options.config);
  ASSERT_TRUE(environment);
  auto counting = std::make_unique<CountingPolicy>();
  const std::vector<std::string>& calls = counting->calls;
  LearnedPolicy policy(std::move(counting));
  ASSERT_EQ(DriveEpisodes(**environment, policy, options.episodes, {}).size(), 2U);
  int begun = 0;
  for (size_t i = 0; i < calls.size(); ++i) {
    const bool begins = calls[i] == "begin";
    begun += begins ? 1 : 0;
    EXPECT_EQ(calls[i] == "act 1", i > 0 && calls[i - 1] == "begin") << i;
  }
  EXPECT_EQ(begun, 2);
  EXPECT_GT(calls.size(), 6U);
}

TEST(DriveEpisodes, ALostEpisodeIsReportedAndTheNextOneIsClean) {
  const EvaluationOptions options = Options("rdm", 1, 3);
  const auto reference = RunEvaluation(options);
  ASSERT_TRUE(reference);
  const auto environment = DrivingEnvironment::Create(options.config);
  ASSERT_TRUE(environment);
  SabotagedPolicy policy(options.episodes[1].seed);
  const auto episodes = DriveEpisodes(**environment, policy, options.episodes, {});
  ASSERT_EQ(episodes.size(), 3U);
  EXPECT_EQ(episodes[0], reference->episodes[0]);
  EXPECT_TRUE(episodes[1].lost());
  EXPECT_EQ(episodes[1].summary.seed, options.episodes[1].seed);
  EXPECT_EQ(episodes[2], reference->episodes[2]);
  EXPECT_EQ(MakeReport("left_turn", "rdm", episodes).lost, 1);
}

TEST(RunEvaluation, StopsWhenNobodyReads) {
  EvaluationOptions options = Options("rdm", 1, 5);
  options.on_episode = [](const EvaluatedEpisode&) { return false; };
  const auto report = RunEvaluation(options);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->episodes.size(), 1U);
}

TEST(RunEvaluation, UnknownScenarioAndPolicyAreTheUsersMistakes) {
  EvaluationOptions options = Options("rdm", 1, 1);
  options.config.scenario = "left_trun";
  const auto scenario = RunEvaluation(options);
  ASSERT_FALSE(scenario);
  EXPECT_EQ(scenario.error().code, ErrorCode::kInvalidArgument);
  const auto policy = RunEvaluation(Options("nobody", 1, 1));
  ASSERT_FALSE(policy);
  EXPECT_EQ(policy.error().code, ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace dadrl
