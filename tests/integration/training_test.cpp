// A training as a user runs it, from the first frame to the results.
#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>
#include <map>

#include "common/util/csv.h"
#include "tests/integration/cluster_under_test.h"
#include "tests/paths.h"

namespace dadrl {
namespace {

using ::testing::HasSubstr;

std::vector<std::string> With(std::vector<std::string> arguments, const std::vector<std::string>& more) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

std::vector<std::string> LeftTurn(const std::vector<std::string>& more = {}) {
  return With(With({"left_turn"}, SmallTraining()), more);
}

struct Episode {
  int actor = 0;
  uint64_t number = 0;
  std::string scenario;
};

// The rows of a run's episodes.csv. Expects that no actor's numbers begin again, and that results.json counts
// every row.
std::vector<Episode> EpisodesOf(const std::filesystem::path& run) {
  std::ifstream table(run / "episodes.csv");
  std::string row;
  std::getline(table, row);
  std::vector<Episode> episodes;
  std::map<int, uint64_t> last;
  while (std::getline(table, row)) {
    const auto cells = CsvCells(row);
    episodes.push_back({.actor = std::stoi(std::string(cells.at(1))),
                        .number = std::stoull(std::string(cells.at(2))),
                        .scenario = std::string(cells.at(12))});
    EXPECT_GT(episodes.back().number, last[episodes.back().actor]) << row;
    last[episodes.back().actor] = episodes.back().number;
  }
  EXPECT_EQ(json::parse(FileText(run / "results.json"))["training_episodes"], episodes.size());
  return episodes;
}

TEST(Training, EndsAfterItsUpdatesWithAnEvaluatedPolicy) {
  const TemporaryFolder folder;
  ClusterUnderTest cluster(folder.path() / "run", LeftTurn({"--set", "learner.max_updates=150"}));
  ASSERT_EQ(cluster.WaitForEnd(240), 0) << cluster.Said();

  const json results = json::parse(FileText(cluster.run() / "results.json"));
  EXPECT_EQ(results["state"], "finished");
  EXPECT_GE(results["updates"], 150);
  EXPECT_GT(results["env_steps"], 0);
  EXPECT_EQ(results["final"]["episodes"], 2);
  const double rates =
      results["final"]["success"].get<double>() + results["final"]["collision"].get<double>() +
      results["final"]["off_road"].get<double>() + results["final"]["stagnation"].get<double>();
  EXPECT_NEAR(rates, 1.0, 1e-9);
  for (const char* name : {"config.yaml", "checkpoints/latest", "checkpoints/best", "logs/learner.log",
                           "logs/replay-0.log", "logs/actor-0.log", "episodes.csv"}) {
    EXPECT_TRUE(std::filesystem::exists(cluster.run() / name)) << name;
  }
  EXPECT_FALSE(EpisodesOf(cluster.run()).empty());
  EXPECT_FALSE(std::filesystem::is_empty(cluster.run() / "tensorboard"));

  // What is graded is the best of the last policies.
  const json selection = json::parse(FileText(cluster.run() / "selection.json"));
  EXPECT_EQ(selection["episodes"], 2);
  EXPECT_EQ(selection["candidates"][0]["updates"], 150);
  EXPECT_EQ(selection["updates"], results["final"]["updates"]);

  // The policy file stands alone: another command evaluates it.
  const CommandOutput evaluation = Dadrl({"evaluate", "--policy", cluster.run() / "checkpoints/best",
                                          "--episodes", "2", "--seeds", "1", "--json"});
  ASSERT_EQ(evaluation.exit_code, 0) << evaluation.err;
  const json report = json::parse(evaluation.out);
  EXPECT_EQ(report["scenario"], "left_turn");
  // The same policy and the same traffic seeds as the final evaluation.
  EXPECT_EQ(report["mean_return"], results["final"]["mean_return"]);
}

TEST(Training, MonitorSeesEverythingFlow) {
  const TemporaryFolder folder;
  ClusterUnderTest cluster(folder.path() / "run", LeftTurn());
  const auto flowing = cluster.MonitorUntil([](const json& monitor) {
    return IsTraining(monitor) && MetricOf(monitor, "actor-0", "policy_version") > 0 &&
           monitor["inserted_frames_per_s"] > 0.0;
  });
  ASSERT_TRUE(flowing) << cluster.Said();
  EXPECT_GT((*flowing)["sampled_transitions_per_s"], 0.0);
  EXPECT_GT((*flowing)["mb_per_s"], 0.0);
  EXPECT_GT((*flowing)["weights_version"], 0.0);
  EXPECT_GE((*flowing)["replay_frames"], 200.0);
  EXPECT_GT((*flowing)["replay_bytes"], 0.0);
  EXPECT_GE((*flowing)["staleness_versions"]["max"], (*flowing)["staleness_versions"]["mean"]);
  EXPECT_FALSE((*flowing)["bottleneck"].get<std::string>().empty());
  EXPECT_FALSE((*flowing)["waits"].empty());
  for (const json& wait : (*flowing)["waits"]) {  // all so far; the fraction is of the last moments
    EXPECT_GE(wait["count"], 1.0) << wait;
    EXPECT_GT(wait["seconds"], 0.0) << wait;
    EXPECT_GE(wait["fraction"], 0.0) << wait;
    EXPECT_LE(wait["fraction"], 1.0) << wait;
  }

  // The actors keep up with the learner's broadcasts.
  const double version = MetricOf(*flowing, "actor-0", "policy_version");
  EXPECT_TRUE(cluster.MonitorUntil([&](const json& monitor) {
    return MetricOf(monitor, "actor-0", "policy_version") > version;
  })) << cluster.Said();

  // A second training cannot take the directory, with or without --resume.
  for (const char* option : {"--resume", "--seed=1"}) {
    const CommandOutput second = Dadrl({"train", "left_turn", option, "--run-dir", cluster.run()});
    EXPECT_EQ(second.exit_code, 1);
    EXPECT_THAT(second.err, HasSubstr("in use by another dadrl"));
  }

  cluster.launcher().Signal(SIGINT);
  EXPECT_EQ(cluster.WaitForEnd(60), 0) << cluster.Said();
  EXPECT_EQ(json::parse(FileText(cluster.run() / "results.json"))["state"], "interrupted");
}

TEST(Training, GoesOnFromWhereItWasInterrupted) {
  const TemporaryFolder folder;
  const auto run = folder.path() / "run";
  double updates = 0;
  size_t episodes = 0;
  // Left by an earlier end: a training that goes on has chosen nothing yet.
  std::filesystem::create_directories(run);
  std::ofstream(run / "selection.json") << "{}";
  {
    ClusterUnderTest cluster(run, LeftTurn());
    ASSERT_TRUE(cluster.MonitorUntil([](const json& monitor) { return monitor["updates"] > 30; }))
        << cluster.Said();
    cluster.launcher().Signal(SIGTERM);
    ASSERT_EQ(cluster.WaitForEnd(60), 0) << cluster.Said();
    updates = json::parse(FileText(run / "results.json"))["updates"];
    episodes = EpisodesOf(run).size();
    EXPECT_FALSE(std::filesystem::exists(run / "selection.json"));
  }
  const CommandOutput changed = Dadrl({"train", "--resume", "--run-dir", run, "--set", "model.hidden=64"});
  EXPECT_EQ(changed.exit_code, 2);
  EXPECT_THAT(changed.err, HasSubstr("--resume cannot change model.hidden from 32 to 64"));

  const int goal = static_cast<int>(updates) + 50;
  ClusterUnderTest cluster(run, {"--resume", "--set", "learner.max_updates=" + std::to_string(goal), "--set",
                                 "evaluation.candidates=1"});
  ASSERT_EQ(cluster.WaitForEnd(180), 0) << cluster.Said();
  const json results = json::parse(FileText(run / "results.json"));
  EXPECT_EQ(results["state"], "finished");
  EXPECT_EQ(results["final"]["updates"], goal);
  EXPECT_GT(EpisodesOf(run).size(), episodes);
  // One candidate: the newest, without a choice.
  EXPECT_EQ(std::filesystem::read_symlink(run / "checkpoints/best"),
            std::filesystem::read_symlink(run / "checkpoints/latest"));
  EXPECT_FALSE(std::filesystem::exists(run / "selection.json"));
}

TEST(Training, AScenariosNameMayHaveSpacesAndMoreInIt) {
  const TemporaryFolder folder;
  const std::string name = "Straße \"neu\"";  // a comma in a path means several files to SUMO
  std::filesystem::create_directories(folder.path() / "scenarios");
  std::filesystem::copy(DADRL_BINARY_DIR "/share/dadrl/scenarios/left_turn",
                        folder.path() / "scenarios" / name, std::filesystem::copy_options::recursive);
  setenv("DADRL_SCENARIOS", (folder.path() / "scenarios").c_str(), 1);
  ClusterUnderTest cluster(folder.path() / "run", With({name}, SmallTraining()));
  unsetenv("DADRL_SCENARIOS");
  const auto driven = cluster.MonitorUntil([](const json& monitor) {
    return IsTraining(monitor) &&
           monitor["recent_episodes"]["count"] > 0.0;  // its telemetry is taken as well
  });
  EXPECT_TRUE(driven) << cluster.Said();
  cluster.launcher().Signal(SIGINT);
  EXPECT_EQ(cluster.WaitForEnd(60), 0) << cluster.Said();
  const auto episodes = EpisodesOf(cluster.run());
  ASSERT_FALSE(episodes.empty());
  for (const Episode& episode : episodes) EXPECT_EQ(episode.scenario, CsvCell(name));
}

TEST(Training, IsTheSameTwiceWhenDeterministic) {
  const TemporaryFolder folder;
  const auto train = [&](const std::string& name) {
    return Dadrl(With({"train"}, LeftTurn({"--deterministic", "--set", "learner.max_updates=20", "--run-dir",
                                           folder.path() / name})));
  };
  const CommandOutput first = train("first");
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_EQ(json::parse(first.out)["updates"], 20);
  EXPECT_EQ(train("second").out, first.out);
  // The folder holds a run now.
  EXPECT_EQ(train("first").exit_code, 2);
}

}  // namespace
}  // namespace dadrl
