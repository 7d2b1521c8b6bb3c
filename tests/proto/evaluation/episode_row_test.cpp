#include "proto/evaluation/episode_row.h"

#include <gtest/gtest.h>

namespace dadrl {
namespace {

TrainingEpisode SomeEpisode() {
  TrainingEpisode episode{.wall_time_ns = 1'795'812'345'123'000'000,
                          .incarnation = 7,
                          .episode = 3,
                          .policy_version = 12,
                          .summary = {}};
  EpisodeSummary& summary = episode.summary;
  summary.scenario = "my, roads";
  summary.seed = 42;
  summary.outcome = Outcome::kCollision;
  summary.steps = 150;
  summary.episode_return = -1.5;
  summary.progress = 0.1;
  summary.mean_speed_mps = 0.2;
  summary.humanness_error = 0.3;
  summary.obstacle_cost = 0.4;
  summary.jerk_cost = 0.5;
  summary.lane_offset_cost = 0.6;
  summary.rule_violation = 0.7;
  summary.distance_to_destination = 0.8;
  summary.time_cost = 0.9;
  summary.overall_score = 1.0 / 3.0;
  return episode;
}

TEST(EpisodeRow, TablesHaveTheColumnsThatScriptsRelyOn) {
  EXPECT_EQ(ActorEpisodeColumns(),
            "time_s,incarnation,episode,seed,outcome,steps,return,progress,mean_speed_mps,humanness_error,"
            "obstacle_cost,jerk_cost,lane_offset_cost,rule_violation,distance_to_destination,time_cost,"
            "overall_score,policy_version,scenario");
  EXPECT_EQ(RunEpisodeColumns(),
            "time_s,actor,episode,seed,outcome,steps,return,progress,mean_speed_mps,humanness_error,"
            "overall_score,policy_version,scenario");
}

TEST(EpisodeRow, RunsRowIsMadeOfTheActors) {
  const std::string row = ActorEpisodeRow(SomeEpisode());
  EXPECT_EQ(row,
            "1795812345.123,7,3,42,collision,150,-1.5,0.1,0.2,0.3,0.4,0.5,0.6,0.7,0.8,0.9,0.333333,12,"
            "\"my, roads\"\n");
  const std::string line = row.substr(0, row.size() - 1);
  const auto key = ActorEpisodeKey(line);
  ASSERT_TRUE(key);
  EXPECT_EQ(key->episode, 3u);
  EXPECT_EQ(key->steps, 150u);
  const std::string run_row = RunEpisodeRow(5, line);
  EXPECT_EQ(run_row, "1795812345.123,5,3,42,collision,150,-1.5,0.1,0.2,0.3,0.333333,12,\"my, roads\"\n");
  int actor = 0;
  const auto run_key = RunEpisodeKey(run_row.substr(0, run_row.size() - 1), actor);
  ASSERT_TRUE(run_key);
  EXPECT_EQ(actor, 5);
  EXPECT_FALSE(ActorEpisodeKey(ActorEpisodeColumns()));
}

}  // namespace
}  // namespace dadrl
