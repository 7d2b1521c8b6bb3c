#include "proto/evaluation/episode_line.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

namespace dadrl {
namespace {

EvaluatedEpisode Sample() {
  EvaluatedEpisode episode;
  episode.group = 3;
  episode.summary.scenario = "left_turn";
  episode.summary.seed = 18446744073709551615ULL;
  episode.summary.outcome = Outcome::kOffRoad;
  episode.summary.steps = 123;
  episode.summary.episode_return = -0.1 - 1e-17;
  episode.summary.progress = 1.0 / 3.0;
  episode.summary.mean_speed_mps = 7.123456789012345;
  episode.summary.humanness_error = 0.1;
  episode.summary.obstacle_cost = 0.2;
  episode.summary.jerk_cost = 0.3;
  episode.summary.lane_offset_cost = 0.4;
  episode.summary.rule_violation = 0.5;
  episode.summary.distance_to_destination = 0.6;
  episode.summary.time_cost = 0.7;
  episode.summary.overall_score = 0.8;
  return episode;
}

TEST(EpisodeLine, RoundTripsExactlyOnOneLine) {
  const std::string line = EpisodeLine(Sample());
  EXPECT_EQ(line.find('\n'), std::string::npos);
  const auto parsed = ParseEpisodeLine(line);
  ASSERT_TRUE(parsed) << parsed.error().message;
  EXPECT_EQ(*parsed, Sample());
}

TEST(EpisodeLine, ACollisionTravelsWithIt) {
  EvaluatedEpisode episode = Sample();
  episode.summary.outcome = Outcome::kCollision;
  episode.summary.collision = CollisionSummary{.side = ContactSide::kRear,
                                               .ego_speed_mps = 10.0 / 3.0,
                                               .other_speed_mps = 7.7,
                                               .relative_heading_rad = -0.1,
                                               .junction = true,
                                               .lane_changer = LaneChanger::kOther};
  std::string line = EpisodeLine(episode);
  const auto parsed = ParseEpisodeLine(line);
  ASSERT_TRUE(parsed) << parsed.error().message;
  EXPECT_EQ(*parsed, episode);
  EXPECT_NE(line.find(R"("kind":"rear_ended")"), std::string::npos);
  line.replace(line.find(R"("rear")"), 6, R"("roof")");
  EXPECT_FALSE(ParseEpisodeLine(line));
}

TEST(EpisodeLine, ALostEpisodeKeepsItsErrorWhateverBytesItHas) {
  EvaluatedEpisode lost;
  lost.group = 1;
  lost.summary.scenario = "left_turn";
  lost.summary.seed = 7;
  lost.error = "vehicle 'a\"b'\nvanished";
  const auto parsed = ParseEpisodeLine(EpisodeLine(lost));
  ASSERT_TRUE(parsed);
  EXPECT_EQ(*parsed, lost);
  lost.error = "bad \xff byte";
  ASSERT_TRUE(ParseEpisodeLine(EpisodeLine(lost)));
  EXPECT_TRUE(ParseEpisodeLine(EpisodeLine(lost))->lost());
}

TEST(EpisodeLine, IsWrittenWhateverBytesItsScenarioHas) {
  EvaluatedEpisode episode = Sample();
  episode.summary.scenario = "left\xff";
  EXPECT_TRUE(ParseEpisodeLine(EpisodeLine(episode)));
}

TEST(EpisodeLine, RefusesWhatIsNotOne) {
  const std::string good = EpisodeLine(Sample());
  for (const std::string& bad :
       {std::string(), std::string("{}"), std::string("[1]"), good.substr(0, good.size() / 2),
        std::string(R"({"group":0,"seed":1,"scenario":"s","outcome":"flew","steps":1})"),
        std::string(R"({"group":0,"seed":1,"scenario":"s","error":""})"),
        std::string(R"({"group":0,"seed":1,"error":"lost"})"),
        std::string(R"({"group":0,"seed":1,"scenario":"s","outcome":"success","steps":"many"})")}) {
    const auto parsed = ParseEpisodeLine(bad);
    ASSERT_FALSE(parsed) << bad;
    EXPECT_EQ(parsed.error().code, ErrorCode::kCorrupt);
  }
}

TEST(Outcome, NamesRoundTrip) {
  for (const Outcome outcome :
       {Outcome::kSuccess, Outcome::kCollision, Outcome::kOffRoad, Outcome::kStagnation}) {
    EXPECT_EQ(OutcomeFromName(OutcomeName(outcome)), outcome);
  }
  EXPECT_EQ(OutcomeName(Outcome::kOffRoad), "off_road");
  EXPECT_FALSE(OutcomeFromName("Success"));
}

TEST(PlanEpisodes, GroupsAreAThousandSeedsApart) {
  const auto plan = PlanEpisodes(1'000'000, 2, 3);
  ASSERT_TRUE(plan);
  const std::vector<PlannedEpisode> expected = {{0, 1'000'000}, {0, 1'000'001}, {0, 1'000'002},
                                                {1, 1'001'000}, {1, 1'001'001}, {1, 1'001'002}};
  EXPECT_EQ(*plan, expected);
}

TEST(PlanEpisodes, RefusesTrainingSeedsAndOverlappingGroups) {
  EXPECT_FALSE(PlanEpisodes(999'999, 1, 1));
  EXPECT_FALSE(PlanEpisodes(1'000'000, 0, 1));
  EXPECT_FALSE(PlanEpisodes(1'000'000, 1, 0));
  EXPECT_FALSE(PlanEpisodes(1'000'000, 2, 1001));
  EXPECT_FALSE(PlanEpisodes(UINT64_MAX - 1500, 2, 1000)) << "the groups would wrap around to 0";
  EXPECT_TRUE(PlanEpisodes(1'000'000, 2, 1000));
}

TEST(EpisodesOfWorker, PartitionThePlan) {
  const auto plan = *PlanEpisodes(2'000'000, 3, 7);
  std::multiset<uint64_t> seeds;
  for (int worker = 0; worker < 4; ++worker) {
    for (const PlannedEpisode& episode : EpisodesOfWorker(plan, worker, 4)) seeds.insert(episode.seed);
  }
  EXPECT_EQ(seeds.size(), plan.size());
  EXPECT_TRUE(std::ranges::all_of(plan, [&](const auto& episode) { return seeds.count(episode.seed) == 1; }));
}

}  // namespace
}  // namespace dadrl
