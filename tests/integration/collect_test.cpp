// Experience without a learner, as a user collects it and learns from it.
#include <gmock/gmock.h>

#include <csignal>

#include "tests/integration/cluster_under_test.h"

namespace dadrl {
namespace {

using ::testing::HasSubstr;

json Inspect(const std::filesystem::path& folder) {
  return json::parse(Dadrl({"replay", "inspect", "--json", folder}).out);
}

std::vector<std::string> Collect(const std::filesystem::path& out, std::vector<std::string> more) {
  more.insert(more.begin(), {"collect", "left_turn", "--policy", "predictive", "--out", out.string(),
                             "--json", "--set", "actor.chunk_frames=16", "--set", "telemetry.enabled=false"});
  return more;
}

TEST(Collect, EndsByItselfWithWhatIsStoredAndGoesOnFromThere) {
  const TemporaryFolder folder;
  const auto out = folder.path() / "successes";
  const CommandOutput first = Dadrl(Collect(out, {"--successes", "3", "--only-successes"}));
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const json summary = json::parse(first.out);
  EXPECT_EQ(summary["finished"], true);
  EXPECT_GE(summary["successes"], 3);
  EXPECT_EQ(summary["episodes"], summary["successes"]);
  const json stored = Inspect(out);
  EXPECT_EQ(stored["ends"]["by_success"], summary["successes"]);
  EXPECT_EQ(stored["transitions"], summary["frames"]);
  EXPECT_EQ(Dadrl({"replay", "verify", out}).exit_code, 0);

  const uint64_t more = summary["successes"].get<uint64_t>() + 2;
  const CommandOutput second =
      Dadrl({"collect", "--resume", "--out", out, "--json", "--successes", std::to_string(more)});
  ASSERT_EQ(second.exit_code, 0) << second.err;
  EXPECT_GE(json::parse(second.out)["successes"], more);
  EXPECT_GT(json::parse(second.out)["frames"], summary["frames"]);

  // Behaviour cloning of nothing but that.
  const CommandOutput trained = Dadrl({"train",        "left_turn",
                                       "--experience", out,
                                       "--actors",     "0",
                                       "--run-dir",    folder.path() / "run",
                                       "--set",        "algorithm.name=bc",
                                       "--set",        "replay.samples_per_insert=0",
                                       "--set",        "replay.min_size=50",
                                       "--set",        "learner.max_updates=30",
                                       "--set",        "model.hidden=32",
                                       "--set",        "evaluation.episodes=1",
                                       "--set",        "evaluation.candidates=1",
                                       "--set",        "evaluation.interval_s=0"});
  ASSERT_EQ(trained.exit_code, 0) << trained.out << trained.err;
  EXPECT_EQ(json::parse(FileText(folder.path() / "run" / "results.json"))["updates"], 30);
}

TEST(Collect, RefusesWhatCannotBeLearntFrom) {
  const TemporaryFolder folder;
  const auto out = folder.path() / "stored";
  ASSERT_EQ(Dadrl(Collect(out, {"--episodes", "1"})).exit_code, 0);
  const auto refusal = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"train", "left_turn", "--run-dir", folder.path() / "run"};
    words.insert(words.end(), more.begin(), more.end());
    const CommandOutput output = Dadrl(words);
    EXPECT_EQ(output.exit_code, 2) << output.err;
    return output.err;
  };
  EXPECT_THAT(refusal({"--experience", out, "--actors", "0"}),
              HasSubstr("replay.samples_per_insert: 8 waits"));
  EXPECT_THAT(refusal({"--experience", out, "--set", "observation.vehicles=5"}),
              HasSubstr("was stored with observation.vehicles: 6, this run has 5"));
  EXPECT_THAT(refusal({"--experience", out, "--deterministic", "--set", "learner.max_updates=1"}),
              HasSubstr("begins with an empty replay"));
  EXPECT_THAT(Dadrl({"train", "left_turn", "--run-dir", folder.path() / "run", "--experience",
                     folder.path() / "nowhere"})
                  .err,
              HasSubstr("holds no run"));
  EXPECT_THAT(Dadrl({"collect", "left_turn", "--policy", "random", "--out", out}).err,
              HasSubstr("--episodes N or --successes N"));
  EXPECT_THAT(Dadrl({"collect", "left_turn", "--out", out, "--episodes", "1"}).err, HasSubstr("who drives?"));
  EXPECT_THAT(Dadrl(Collect(out, {"--episodes", "1"})).err, HasSubstr("holds a run already"));
}

// Whoever is killed is started again, and what is stored is whole.
class CollectUnderFire : public testing::TestWithParam<std::string> {};

TEST_P(CollectUnderFire, StoresWhatWasAskedForAllTheSame) {
  const TemporaryFolder folder;
  const auto out = folder.path() / "out";
  std::vector<std::string> command = Collect(out, {"--episodes", "12"});
  command.insert(command.begin(), DadrlProgram());
  auto launcher = ChildProcess::Spawn({.command = command, .log = folder.path() / "log"});
  ASSERT_TRUE(launcher);
  const auto episodes = [&] {
    const json stored = json::parse(Dadrl({"replay", "inspect", "--json", out}).out, nullptr, false);
    return stored.is_object() ? stored["ends"]["terminated"].get<int>() : 0;
  };
  ASSERT_TRUE(Eventually([&] { return episodes() >= 2; }, std::chrono::seconds(90)))
      << FileText(folder.path() / "log");
  const std::string name = GetParam();
  pid_t victim = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string words = FileText(entry.path() / "cmdline");
    const bool is_program = words.substr(0, words.find('\0')).ends_with(name);
    const bool serves =
        words.find(out.string()) != std::string::npos && words.find("inspect") == std::string::npos;
    if (is_program && serves) victim = std::stoi(entry.path().filename());
  }
  ASSERT_GT(victim, 0);
  ASSERT_EQ(kill(victim, SIGKILL), 0);
  const auto ended = launcher->Wait(std::chrono::seconds(120));
  ASSERT_TRUE(ended && ended->success()) << FileText(folder.path() / "log");
  const json stored = Inspect(out);
  EXPECT_GE(stored["ends"]["terminated"].get<int>() + stored["ends"]["truncated"].get<int>(), 12);
  EXPECT_EQ(Dadrl({"replay", "verify", out}).exit_code, 0);
}

INSTANTIATE_TEST_SUITE_P(Roles, CollectUnderFire, testing::Values("dadrl-actor", "dadrl-replay"));

}  // namespace
}  // namespace dadrl
