#include "proto/evaluation/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "proto/evaluation/wilson.h"

namespace dadrl {
namespace {

EvaluatedEpisode Episode(int group, uint64_t seed, Outcome outcome, int steps, double episode_return) {
  EvaluatedEpisode episode;
  episode.group = group;
  episode.summary.scenario = "left_turn";
  episode.summary.seed = seed;
  episode.summary.outcome = outcome;
  episode.summary.steps = steps;
  episode.summary.episode_return = episode_return;
  episode.summary.humanness_error = 0.25;
  episode.summary.overall_score = steps / 1000.0;
  return episode;
}

std::vector<EvaluatedEpisode> Sample() {
  EvaluatedEpisode lost;
  lost.group = 1;
  lost.summary.scenario = "left_turn";
  lost.summary.seed = 1'001'002;
  lost.error = "a vehicle, \"b\", vanished";
  return {Episode(0, 1'000'000, Outcome::kSuccess, 100, 5.0),
          Episode(0, 1'000'001, Outcome::kCollision, 50, -0.5),
          Episode(1, 1'001'000, Outcome::kSuccess, 200, 4.5),
          Episode(1, 1'001'001, Outcome::kStagnation, 800, 1.0), lost};
}

TEST(EvaluationReport, RatesMeansAndGroupsAreThoseOfTheEpisodes) {
  const EvaluationReport report = MakeReport("left_turn", "rdm", Sample());
  EXPECT_EQ(report.all.episodes, 4);
  EXPECT_EQ(report.lost, 1);
  EXPECT_DOUBLE_EQ(report.all.success, 0.5);
  EXPECT_DOUBLE_EQ(report.all.collision, 0.25);
  EXPECT_DOUBLE_EQ(report.all.off_road, 0.0);
  EXPECT_DOUBLE_EQ(report.all.stagnation, 0.25);
  EXPECT_DOUBLE_EQ(report.all.mean.episode_return, 2.5);
  EXPECT_DOUBLE_EQ(report.all.median_steps, 150);
  EXPECT_DOUBLE_EQ(report.all.mean.humanness_error, 0.25);
  EXPECT_EQ(report.all.success_ci95, WilsonInterval(2, 4));
  ASSERT_EQ(report.per_seed.size(), 2U);
  EXPECT_EQ(report.per_seed[1].first_seed, 1'001'000U);
  EXPECT_EQ(report.per_seed[1].figures.episodes, 2);
  EXPECT_DOUBLE_EQ(report.per_seed[1].figures.success, 0.5);
  EXPECT_DOUBLE_EQ(report.per_seed[0].figures.mean.episode_return, 2.25);
}

TEST(EvaluationReport, DoesNotDependOnTheOrderEpisodesFinishIn) {
  std::vector<EvaluatedEpisode> episodes = Sample();
  const std::string reference = ReportJson(MakeReport("s", "p", episodes));
  std::ranges::reverse(episodes);
  EXPECT_EQ(ReportJson(MakeReport("s", "p", episodes)), reference);
}

TEST(EvaluationReport, CountsCollisionsByKindTheMostFrequentFirst) {
  std::vector<EvaluatedEpisode> episodes = Sample();
  const CollisionSummary ran_into{.ego_speed_mps = 5.0};
  const CollisionSummary crossing{.ego_speed_mps = 5.0, .relative_heading_rad = 1.5};
  episodes[1].summary.collision = crossing;
  for (uint64_t seed = 1'000'010; seed < 1'000'012; ++seed) {
    episodes.push_back(Episode(0, seed, Outcome::kCollision, 10, -1.0));
    episodes.back().summary.collision = ran_into;
  }
  const EvaluationReport report = MakeReport("left_turn", "rdm", episodes);
  EXPECT_EQ(report.collision_kinds, (std::map<std::string, int>{{"crossing", 1}, {"ran_into", 2}}));
  EXPECT_EQ(nlohmann::json::parse(ReportJson(report))["collision_kinds"]["ran_into"], 2);
  EXPECT_THAT(ReportTable(report), testing::HasSubstr("collisions: 2 ran_into, 1 crossing\n"));
  EXPECT_THAT(ReportCsv(report), testing::HasSubstr(",crossing,front,5,0,1.5,false,nobody,\n"));
}

TEST(EvaluationReport, SeveralScenariosHaveARowEach) {
  std::vector<EvaluatedEpisode> episodes = Sample();
  episodes.push_back(Episode(0, 1'000'000, Outcome::kCollision, 30, -1.0));
  episodes.back().summary.scenario = "double_merge";
  const EvaluationReport report = MakeReport("all", "p", episodes);
  EXPECT_EQ(report.all.episodes, 5);
  EXPECT_EQ(report.per_seed[0].figures.episodes, 3);
  ASSERT_EQ(report.per_scenario.size(), 2U);
  EXPECT_EQ(report.per_scenario[0].scenario, "double_merge");
  EXPECT_EQ(report.per_scenario[0].figures.collision_ci95, WilsonInterval(1, 1));
  EXPECT_EQ(report.per_scenario[1].figures.episodes, 4);
  const auto json = nlohmann::json::parse(ReportJson(report));
  EXPECT_EQ(json["per_scenario"][1]["scenario"], "left_turn");
  EXPECT_EQ(json["per_scenario"][1]["success"], 0.5);
  EXPECT_THAT(ReportTable(report), testing::HasSubstr("\ndouble_merge "));
  EXPECT_THAT(ReportCsv(report), testing::HasSubstr("\ndouble_merge,\"p\",0,1000000,collision,"));
  EXPECT_FALSE(nlohmann::json::parse(ReportJson(MakeReport("s", "p", Sample()))).contains("per_scenario"));
}

TEST(EvaluationReport, JsonHasTheKeysThatScriptsRelyOn) {
  const auto json = nlohmann::ordered_json::parse(ReportJson(MakeReport("left_turn", "rdm", Sample())));
  std::vector<std::string> keys;
  for (const auto& [key, value] : json.items()) keys.push_back(key);
  EXPECT_THAT(keys, testing::ElementsAre("scenario", "policy", "episodes", "success", "collision", "off_road",
                                         "stagnation", "mean_return", "median_steps", "mean_speed_mps",
                                         "humanness_error", "obstacle_cost", "jerk_cost", "lane_offset_cost",
                                         "rule_violation", "distance_to_destination", "time_cost",
                                         "overall_score", "success_ci95", "collision_ci95", "off_road_ci95",
                                         "stagnation_ci95", "collision_kinds", "lost_episodes", "per_seed"));
  EXPECT_EQ(json["scenario"], "left_turn");
  EXPECT_EQ(json["episodes"], 4);
  EXPECT_EQ(json["success_ci95"].size(), 2U);
  EXPECT_EQ(json["per_seed"].size(), 2U);
  EXPECT_EQ(json["per_seed"][1]["first_seed"], 1'001'000);
}

TEST(EvaluationReport, AnEmptyOrWhollyLostOneIsStillWhole) {
  EXPECT_EQ(MakeReport("s", "p", {}).all.episodes, 0);
  const EvaluationReport lost = MakeReport("s", "p", {Sample().back()});
  EXPECT_EQ(lost.lost, 1);
  EXPECT_EQ(lost.all.episodes, 0);
  EXPECT_TRUE(nlohmann::json::accept(ReportJson(lost)));
  EXPECT_FALSE(ReportTable(lost).empty());
}

TEST(EvaluationReport, TableShowsRatesIntervalsAndLosses) {
  const std::string table = ReportTable(MakeReport("left_turn", "rdm", Sample()));
  EXPECT_THAT(table, testing::HasSubstr("left_turn"));
  EXPECT_THAT(table, testing::HasSubstr("50.0"));
  EXPECT_THAT(table, testing::HasSubstr("15.0-85.0"));  // Wilson interval of 2 of 4
  EXPECT_THAT(table, testing::HasSubstr("1 episodes were lost"));
}

TEST(EvaluationReport, CsvHasARowForEveryEpisodeWithTheHeadersColumns) {
  auto episodes = Sample();
  episodes[0].summary.scenario = "ramp, steep";
  const std::string csv = ReportCsv(MakeReport("left_turn", "a,\"b\".policy", std::move(episodes)));
  std::vector<std::string> lines;
  for (size_t begin = 0; begin < csv.size();) {
    const size_t end = csv.find('\n', begin);
    lines.push_back(csv.substr(begin, end - begin));
    begin = end + 1;
  }
  ASSERT_EQ(lines.size(), 6U);
  // Commas outside quotes.
  const auto columns = [](const std::string& line) {
    int commas = 0;
    bool quoted = false;
    for (const char c : line) {
      if (c == '"') quoted = !quoted;
      if (c == ',' && !quoted) ++commas;
    }
    return commas;
  };
  for (const std::string& line : lines) EXPECT_EQ(columns(line), columns(lines[0])) << line;
  EXPECT_THAT(csv, testing::HasSubstr("\n\"ramp, steep\","));
  EXPECT_THAT(lines[2], testing::HasSubstr(",1000001,collision,50,-0.5,"));
  EXPECT_THAT(lines[5], testing::HasSubstr("\"a vehicle, \"\"b\"\", vanished\""));
}

}  // namespace
}  // namespace dadrl
