// Every wrong input: one clear line on standard error, nothing on standard output, exit code 1 or 2.
#include <gmock/gmock.h>
#include <sys/socket.h>

#include <algorithm>
#include <fstream>

#include "common/dds/node.h"
#include "common/dds/udp_socket.h"
#include "tests/deploy/cli/run_command.h"

namespace dadrl {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct BadInput {
  const char* name;
  std::vector<std::string> arguments;
  int exit_code;
  const char* message;
};

class BadInputTest : public testing::TestWithParam<BadInput> {};

TEST_P(BadInputTest, IsRefusedInOneLine) {
  const BadInput& input = GetParam();
  const CommandOutput output = Dadrl(input.arguments);
  EXPECT_EQ(output.exit_code, input.exit_code) << output.err;
  EXPECT_THAT(output.out, IsEmpty());
  EXPECT_THAT(output.err, HasSubstr(input.message));
  EXPECT_EQ(std::count(output.err.begin(), output.err.end(), '\n'), 1) << output.err;
}

INSTANTIATE_TEST_SUITE_P(
    All, BadInputTest,
    testing::Values(
        BadInput{"UnknownCommand", {"trian"}, 2, "the nearest is 'train'"},
        BadInput{"NoCommand", {}, 2, "dadrl"},
        BadInput{"UnknownOption", {"train", "left_turn", "--actros", "3"}, 2, "--actros"},
        BadInput{"NoScenario", {"train"}, 2, "left_turn"},
        BadInput{"UnknownScenario",
                 {"train", "lft_turn"},
                 2,
                 "unknown scenario 'lft_turn'; the nearest is 'left_turn'"},
        BadInput{"UnknownKey",
                 {"train", "left_turn", "--set", "algorithm.gama=0.9"},
                 2,
                 "unknown key 'algorithm.gama'; the nearest is 'algorithm.gamma'"},
        BadInput{"ValueOutOfRange",
                 {"train", "left_turn", "--set", "algorithm.gamma=2"},
                 2,
                 "algorithm.gamma: '2' is not a number between 0 and 1"},
        BadInput{"DeterministicResume",
                 {"train", "left_turn", "--deterministic", "--resume"},
                 2,
                 "--deterministic with --resume"},
        BadInput{"NotANumber", {"train", "left_turn", "--actors", "many"}, 2, "--actors"},
        BadInput{"TooManyActors", {"train", "left_turn", "--actors", "100000"}, 2, "actor.count"},
        BadInput{"NegativeMinutes", {"train", "left_turn", "--minutes", "-1"}, 2, "minutes"},
        BadInput{
            "Contradiction", {"train", "left_turn", "--set", "algorithm.batch_size=40"}, 2, "multiple of 16"},
        BadInput{
            "MissingConfigFile", {"train", "left_turn", "--config", "/no/such.yaml"}, 2, "/no/such.yaml"},
        BadInput{"NothingToResume", {"train", "--resume", "--run-dir", "/no/such/run"}, 1, "holds no run"},
        BadInput{"MissingPolicy",
                 {"evaluate", "--policy", "/no/such.dadrl", "--scenario", "left_turn"},
                 1,
                 "/no/such.dadrl"},
        BadInput{"UnknownPretrained", {"evaluate", "--policy", "pretrained:no_such"}, 2, "no_such"},
        BadInput{"EvaluateWithoutScenario", {"evaluate", "--policy", "rdm"}, 2, "--scenario is needed"},
        BadInput{"EvaluateUnknownScenario",
                 {"evaluate", "--policy", "rdm", "--scenario", "roundabout_d"},
                 2,
                 "the nearest is 'roundabout_"},
        BadInput{"TrainingSeeds",
                 {"evaluate", "--policy", "rdm", "--scenario", "left_turn", "--first-seed", "5"},
                 2,
                 "1000000"},
        BadInput{"NoEpisodes",
                 {"evaluate", "--policy", "rdm", "--scenario", "left_turn", "--episodes", "0"},
                 2,
                 "--episodes"},
        BadInput{"ImpatienceTooLarge",
                 {"evaluate", "--policy", "idm", "--scenario", "left_turn", "--impatience", "2"},
                 2,
                 "--impatience"},
        BadInput{"HoldOfNothing",
                 {"evaluate", "--policy", "random", "--scenario", "left_turn", "--hold", "0"},
                 2,
                 "--hold"},
        BadInput{"HoldOfAnotherDriver",
                 {"evaluate", "--policy", "rdm", "--scenario", "left_turn", "--hold", "5"},
                 2,
                 "--hold is for --policy random, not for rdm"},
        BadInput{"RenderUnknownEnding",
                 {"render", "--policy", "rdm", "--scenario", "left_turn", "--out", "episode.gif"},
                 2,
                 "'episode.gif' does not say what to draw; end it in .svg"},
        BadInput{"RenderWithoutScenario",
                 {"render", "--policy", "rdm", "--out", "a.png"},
                 2,
                 "--scenario is needed"},
        BadInput{"RenderOfAllScenarios",
                 {"render", "--policy", "rdm", "--scenario", "all", "--out", "a.png"},
                 2,
                 "one scenario is drawn: choose it with --scenario; there are: double_merge, left_turn"},
        BadInput{"RenderUnknownPolicy",
                 {"render", "--policy", "rmd", "--scenario", "left_turn", "--out", "a.png"},
                 2,
                 "policy 'rmd' is neither a file nor one of"},
        BadInput{
            "RenderSeedsWithoutCount",
            {"render", "--policy", "rdm", "--scenario", "left_turn", "--seeds", "1000000", "--out", "a/"},
            2,
            "'1000000' is not FIRST:COUNT"},
        BadInput{"RenderSeedsIntoOneFile",
                 {"render", "--policy", "rdm", "--scenario", "left_turn", "--seeds", "1000000:5", "--out",
                  "a.png"},
                 2,
                 "'a.png' does not end in /"},
        BadInput{"RenderUnknownOutcome",
                 {"render", "--policy", "rdm", "--scenario", "left_turn", "--seeds", "1000000:5", "--out",
                  "a/", "--outcome", "crash"},
                 2,
                 "--outcome"},
        BadInput{"RenderIntoNoFolder",
                 {"render", "--policy", "rdm", "--scenario", "left_turn", "--out", "/no/such/folder/a.png"},
                 1,
                 "there is no folder /no/such/folder"},
        BadInput{
            "RenderBeyondTheEnd",
            {"render", "--policy", "rdm", "--scenario", "left_turn", "--out", "/tmp/a.png", "--from", "79"},
            2,
            "--from 79: the episode of seed 1000000 ends after"},
        BadInput{"SelectWithoutRun", {"select", "--run-dir", "/no/such/run"}, 1, "holds no run"},
        BadInput{"SelectFromNone", {"select", "--candidates", "0"}, 2, "--candidates"},
        BadInput{"SelectOnNothing", {"select", "--episodes", "0"}, 2, "--episodes"},
        BadInput{"SelectOnTooMuch", {"select", "--episodes", "1001"}, 2, "--episodes"},
        BadInput{"NoCandidates",
                 {"train", "left_turn", "--set", "evaluation.candidates=0"},
                 2,
                 "evaluation.candidates"},
        BadInput{"MonitorWithoutRun", {"monitor", "--run-dir", "/no/such/run"}, 1, "holds no run"},
        BadInput{"JoinNobody", {"actor", "--join", "no.such.host.invalid"}, 2, "no.such.host.invalid"},
        BadInput{
            "JoinUnknownKey", {"actor", "--join", "127.0.0.1", "--set", "actor.cont=2"}, 2, "actor.count"},
        BadInput{"JoinBadPort", {"actor", "--join", "10.0.0.1:99999"}, 2, "10.0.0.1:99999"}),
    [](const auto& test) { return test.param.name; });

TEST(BadInput, CorruptPolicyIsNamed) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "policy.dadrl";
  std::ofstream(file) << "not a policy at all, whatever its name says";
  const CommandOutput output = Dadrl({"evaluate", "--policy", file, "--scenario", "left_turn"});
  EXPECT_EQ(output.exit_code, 1);
  EXPECT_THAT(output.err, HasSubstr(file.string()));
  EXPECT_THAT(output.out, IsEmpty());
}

TEST(BadInput, BrokenConfigFileIsNamedWithItsLine) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "run.yaml";
  std::ofstream(file) << "seed: 3\nreplay:\n  min_sise: 5\n";
  const CommandOutput output = Dadrl({"train", "left_turn", "--config", file});
  EXPECT_EQ(output.exit_code, 2);
  EXPECT_THAT(output.err,
              HasSubstr("run.yaml:3: unknown key 'replay.min_sise'; the nearest is 'replay.min_size'"));
}

TEST(BadInput, TakenPortIsNamed) {
  const auto base = dds::FindFreePort();
  ASSERT_TRUE(base) << base.error().message;
  dds::UdpSocket taken;
  ASSERT_TRUE(taken.Bind(*base + 12));
  const TemporaryFolder folder;
  const auto run = folder.path() / "run";
  const CommandOutput output =
      Dadrl({"train", "left_turn", "--run-dir", run, "--set", "cluster.port=" + std::to_string(*base)});
  EXPECT_EQ(output.exit_code, 1);
  EXPECT_THAT(output.err, HasSubstr("UDP port " + std::to_string(*base + 12)));
  EXPECT_FALSE(std::filesystem::exists(run));
}

TEST(BadInput, ExistingRunIsNotOverwritten) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "config.yaml") << "seed: 3\n";
  const CommandOutput output = Dadrl({"train", "left_turn", "--run-dir", folder.path()});
  EXPECT_EQ(output.exit_code, 2);
  EXPECT_THAT(output.err, HasSubstr("--resume"));
  EXPECT_EQ(FileText(folder.path() / "config.yaml"), "seed: 3\n");
}

TEST(BadInput, MonitorOfAStoppedRunSaysSo) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "config.yaml") << "seed: 3\n";
  const CommandOutput output = Dadrl({"monitor", "--json", "--run-dir", folder.path()});
  EXPECT_EQ(output.exit_code, 1);
  EXPECT_THAT(output.err, HasSubstr("is not running"));
  EXPECT_THAT(output.out, IsEmpty());
}

}  // namespace
}  // namespace dadrl
