#include "deploy/local/policy_selection.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/deploy/local/saved_policies.h"
#include "tests/deploy/local/test_processes.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

EvaluationFigures Figures(double success, double collision, double median_steps) {
  EvaluationFigures figures;
  figures.success = success;
  figures.collision = collision;
  figures.median_steps = median_steps;
  return figures;
}

TEST(DrivesBetter, SuccessThenCollisionsAndNoHaste) {
  EXPECT_TRUE(DrivesBetter(Figures(0.98, 0.02, 300), Figures(0.97, 0.0, 100)));
  EXPECT_TRUE(DrivesBetter(Figures(0.98, 0.01, 300), Figures(0.98, 0.02, 100)));
  EXPECT_FALSE(DrivesBetter(Figures(0.98, 0.01, 100), Figures(0.98, 0.01, 101)));
  EXPECT_FALSE(DrivesBetter(Figures(0.98, 0.01, 101), Figures(0.98, 0.01, 100)));
}

class PolicySelectionTest : public testing::Test {
 protected:
  Result<std::vector<SavedPolicy>> Newest(int count) {
    return NewestPolicies(paths_, count, [this](const std::string& text) { warnings_.push_back(text); });
  }
  // The policy of `updates`, with these of four episodes.
  Candidate Drove(uint64_t updates, int successes, int collisions) {
    std::vector<EvaluatedEpisode> episodes(4);
    for (int i = 0; i < 4; ++i) {
      episodes[static_cast<size_t>(i)].summary.seed = kFirstValidationSeed + static_cast<uint64_t>(i);
      episodes[static_cast<size_t>(i)].summary.outcome = i < successes                ? Outcome::kSuccess
                                                         : i < successes + collisions ? Outcome::kCollision
                                                                                      : Outcome::kStagnation;
    }
    return {SavePolicyAt(paths_, updates), MakeReport("left_turn", "candidate", std::move(episodes))};
  }
  static Selection Of(std::vector<Candidate> candidates) {
    return {.scenario = "left_turn",
            .first_seed = kFirstValidationSeed,
            .episodes = 4,
            .candidates = std::move(candidates)};
  }

  const TemporaryFolder folder_;
  const RunPaths paths_{.root = folder_.path()};
  std::vector<std::string> warnings_;
};

TEST_F(PolicySelectionTest, FindsTheNewestPoliciesAndNothingElse) {
  for (const uint64_t updates : {900u, 10'000u, 2'000u}) SavePolicyAt(paths_, updates);
  std::ofstream(paths_.checkpoints() / "checkpoint-000010000.ckpt") << "not a policy";
  fs::create_symlink("policy-000010000.dadrl", paths_.policy());
  const auto two = Newest(2);
  ASSERT_TRUE(two) << two.error().message;
  ASSERT_EQ(two->size(), 2u);
  EXPECT_EQ((*two)[0].updates, 10'000u);
  EXPECT_EQ((*two)[0].policy_version, 1'000u);
  EXPECT_EQ((*two)[1].updates, 2'000u);
  EXPECT_EQ(Newest(50)->size(), 3u);
  EXPECT_THAT(warnings_, IsEmpty());
}

TEST_F(PolicySelectionTest, LeavesADamagedPolicyOutAndNamesIt) {
  const SavedPolicy older = SavePolicyAt(paths_, 10);
  const SavedPolicy damaged = SavePolicyAt(paths_, 20);
  fs::resize_file(damaged.file, fs::file_size(damaged.file) - 1);
  const auto policies = Newest(2);
  ASSERT_TRUE(policies);
  ASSERT_EQ(policies->size(), 1u);
  EXPECT_EQ(policies->front().file, older.file);
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr(damaged.file.string())));
}

TEST_F(PolicySelectionTest, WithoutPoliciesSaysWhatToDo) {
  const auto none = Newest(8);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(none.error().message,
              AllOf(HasSubstr(paths_.checkpoints().string()), HasSubstr("learner.checkpoint_interval_s")));
}

TEST_F(PolicySelectionTest, AmongEqualsTheNewestIsChosen) {
  const Selection selection = Of({Drove(30, 3, 1), Drove(20, 3, 0), Drove(10, 3, 0)});
  EXPECT_EQ(selection.chosen().policy.updates, 20u);
}

TEST_F(PolicySelectionTest, LinksTheChosenPolicyAndRecordsHowAllDrove) {
  const Selection selection = Of({Drove(30, 2, 1), Drove(20, 3, 1)});
  ASSERT_TRUE(SaveSelection(paths_, selection));
  const auto best = LoadPolicy(paths_.best_policy());
  ASSERT_TRUE(best) << best.error().message;
  EXPECT_EQ(best->updates, 20u);
  const json record = json::parse(FileText(paths_.selection()));
  EXPECT_EQ(record["chosen"], "policy-000000020.dadrl");
  EXPECT_EQ(record["updates"], 20);
  EXPECT_EQ(record["first_seed"], kFirstValidationSeed);
  EXPECT_EQ(record["episodes"], 4);
  ASSERT_EQ(record["candidates"].size(), 2u);
  EXPECT_EQ(record["candidates"][0]["updates"], 30);
  EXPECT_EQ(record["candidates"][0]["success"], 0.5);
  EXPECT_EQ(record["candidates"][1]["collision"], 0.25);
}

TEST_F(PolicySelectionTest, ALaterChoiceReplacesAnEarlierOne) {
  ASSERT_TRUE(SaveSelection(paths_, Of({Drove(30, 2, 1), Drove(20, 3, 1)})));
  ASSERT_TRUE(SaveSelection(paths_, Of({Drove(40, 4, 0), Drove(30, 2, 1)})));
  EXPECT_EQ(LoadPolicy(paths_.best_policy())->updates, 40u);
  EXPECT_EQ(json::parse(FileText(paths_.selection()))["updates"], 40);
}

TEST_F(PolicySelectionTest, TheNewestWithoutAChoiceHasNoRecord) {
  ASSERT_TRUE(SaveSelection(paths_, Of({Drove(30, 2, 1), Drove(20, 3, 1)})));
  ASSERT_TRUE(TakeNewest(paths_, SavePolicyAt(paths_, 30)));
  EXPECT_EQ(LoadPolicy(paths_.best_policy())->updates, 30u);
  EXPECT_FALSE(fs::exists(paths_.selection()));
}

TEST_F(PolicySelectionTest, IsForgottenWithLinkAndRecord) {
  ASSERT_TRUE(SaveSelection(paths_, Of({Drove(20, 3, 1)})));
  ForgetSelection(paths_);
  EXPECT_FALSE(fs::exists(fs::symlink_status(paths_.best_policy())));
  EXPECT_FALSE(fs::exists(paths_.selection()));
  ForgetSelection(paths_);
}

TEST_F(PolicySelectionTest, TableMarksTheChosenOneAndWhatTheSimulatorLost) {
  Selection selection = Of({Drove(30'000, 2, 1), Drove(20'000, 3, 1)});
  selection.candidates[0].report.lost = 1;
  const std::string table = SelectionTable(selection);
  EXPECT_THAT(table, HasSubstr("left_turn: 4 episodes each, traffic seeds 2000000 to 2000003\n"));
  EXPECT_THAT(table, testing::ContainsRegex("30,000 +50\\.0 .*  1 lost to the simulator\n"));
  EXPECT_THAT(table, testing::ContainsRegex("20,000 +75\\.0 +25\\.0 .*  chosen\n"));
}

}  // namespace
}  // namespace dadrl
