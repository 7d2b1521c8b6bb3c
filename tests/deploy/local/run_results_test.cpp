#include "deploy/local/run_results.h"

#include <gmock/gmock.h>

#include "common/io/atomic_file.h"
#include "proto/evaluation/episode_row.h"
#include "tests/deploy/local/test_processes.h"

namespace dadrl {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

void Save(const RunResults& results, const std::filesystem::path& file) {
  ASSERT_TRUE(WriteFileAtomically(file, std::string_view(results.Text())));
}

EvaluationReport Report(int successes, int collisions) {
  std::vector<EvaluatedEpisode> episodes;
  for (int i = 0; i < successes + collisions; ++i) {
    EvaluatedEpisode episode;
    episode.summary.seed = kFirstEvaluationSeed + static_cast<uint64_t>(i);
    episode.summary.outcome = i < successes ? Outcome::kSuccess : Outcome::kCollision;
    episodes.push_back(episode);
  }
  return MakeReport("left_turn", "test", std::move(episodes));
}

TEST(RunResults, AccumulateOverSessions) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "results.json";
  TrainedSoFar trained{.updates = 100, .cpu_s = 31.5, .weights_version = 6};
  auto episodes = EpisodeLog::Open(folder.path() / "episodes.csv", folder.path() / "logs");
  ASSERT_TRUE(episodes);
  const auto drive = [&](int steps) {
    std::filesystem::create_directories(folder.path() / "logs");
    std::ofstream log(folder.path() / "logs" / "episodes-actor-0.csv", std::ios::app);
    if (log.tellp() == 0) log << ActorEpisodeColumns() << '\n';
    TrainingEpisode episode;
    episode.summary.steps = steps;
    log << ActorEpisodeRow(episode) << std::flush;
    ASSERT_TRUE(episodes->Update());
  };
  drive(300);
  {
    RunResults results = RunResults::Load(file, Config{});
    results.AddEvaluation({.elapsed_s = 30, .env_steps = 2500, .updates = 50, .policy_version = 7},
                          Report(3, 1));
    results.Update("interrupted", 60.0, trained, *episodes);
    Save(results, file);
  }
  RunResults results = RunResults::Load(file, Config{});
  EXPECT_EQ(results.earlier_s(), 60.0);
  results.SetFinal({.elapsed_s = 80, .updates = 150, .policy_version = 9}, Report(4, 0));
  trained.updates = 150;
  drive(400);
  results.Update("finished", 20.0, trained, *episodes);
  Save(results, file);

  const json saved = json::parse(FileText(file));
  EXPECT_EQ(saved["state"], "finished");
  EXPECT_FALSE(saved["commit"].get<std::string>().empty());
  EXPECT_THAT(saved["machine"].get<std::string>(), HasSubstr(" cores"));
  EXPECT_EQ(saved["training_s"], 80.0);
  EXPECT_EQ(saved["updates"], 150);
  EXPECT_EQ(saved["learner_cpu_s"], 31.5);
  EXPECT_EQ(saved["env_steps"], 700);
  EXPECT_EQ(saved["training_episodes"], 2);
  ASSERT_EQ(saved["evaluations"].size(), 1u);
  EXPECT_EQ(saved["evaluations"][0]["success"], 0.75);
  EXPECT_EQ(saved["evaluations"][0]["policy_version"], 7);
  EXPECT_EQ(saved["evaluations"][0]["env_steps"], 2500);
  EXPECT_EQ(saved["final"]["success"], 1.0);
  EXPECT_THAT(LastEvaluation(file), HasSubstr("150 updates: success 100.0 %"));
}

TEST(RunResults, SumsUpWhatFaultsTookOverSessions) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "results.json";
  LostTime lost;
  lost.Add("replay-0: hangs", std::chrono::seconds(8));
  {
    RunResults results = RunResults::Load(file, Config{});
    results.SetLost(lost);
    results.SetLost(lost);  // the same session, later
    Save(results, file);
  }
  RunResults results = RunResults::Load(file, Config{});
  lost.Add("learner: starts again", std::chrono::seconds(2));
  results.SetLost(lost);
  Save(results, file);
  EXPECT_EQ(json::parse(FileText(file))["lost_s"],
            json({{"learner: starts again", 2.0}, {"replay-0: hangs", 16.0}}));
}

TEST(RunResults, ReplacesADamagedFileAndKeepsItAside) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "results.json";
  for (const char* damage : {"{\"state\": \"run", "[1, 2]", ""}) {
    std::ofstream(file, std::ios::trunc) << damage;
    const RunResults results = RunResults::Load(file, Config{});
    EXPECT_EQ(results.earlier_s(), 0.0);
    Save(results, file);
    EXPECT_EQ(json::parse(FileText(file))["scenario"], "left_turn");
    EXPECT_EQ(FileText(file.string() + ".corrupt"), damage);
  }
}

TEST(RunResults, SurvivesOtherTypes) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "results.json";
  std::ofstream(file) << R"({"training_s": "long", "evaluations": 3})";
  EXPECT_EQ(RunResults::Load(file, Config{}).earlier_s(), 0.0);
  EXPECT_EQ(LastEvaluation(file), "");
  EXPECT_EQ(LastEvaluation(folder.path() / "missing.json"), "");
}

}  // namespace
}  // namespace dadrl
