// `dadrl scenario check`, and that train, evaluate and render ask it first.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/deploy/cli/run_command.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

constexpr const char* kBuilt = DADRL_BINARY_DIR "/share/dadrl/scenarios";

// A folder with `broken`: the left turn, whose route goes nowhere.
class ScenarioCommand : public testing::Test {
 protected:
  ScenarioCommand() {
    fs::copy(fs::path(kBuilt) / "left_turn", folder_.path() / "broken");
    std::string yaml = FileText(folder_.path() / "broken/scenario.yaml");
    yaml.replace(yaml.find("west-EW_0"), 9, "west-EW_5");
    std::ofstream(folder_.path() / "broken/scenario.yaml") << yaml;
  }
  ~ScenarioCommand() override { unsetenv("DADRL_SCENARIOS"); }
  std::string Broken() const { return folder_.path() / "broken"; }

  const TemporaryFolder folder_;
};

TEST_F(ScenarioCommand, ExplainsAFolderAndAName) {
  for (const std::string scenario : {"left_turn", DADRL_BINARY_DIR "/share/dadrl/scenarios/left_turn/"}) {
    const CommandOutput output = Dadrl({"scenario", "check", scenario});
    EXPECT_EQ(output.exit_code, 0) << output.err;
    EXPECT_THAT(output.out, AllOf(StartsWith("scenario  left_turn: "), HasSubstr("\nroute     south-SN_1"),
                                  HasSubstr("\nverdict   can be driven\n")));
    EXPECT_EQ(output.err, "");
  }
}

TEST_F(ScenarioCommand, IsRefusedInTheSameWordsByEverythingThatDrives) {
  const CommandOutput check = Dadrl({"scenario", "check", Broken()});
  EXPECT_EQ(check.exit_code, 2);
  EXPECT_EQ(check.out, "");
  ASSERT_THAT(check.err,
              AllOf(StartsWith("dadrl scenario: "), HasSubstr("broken/scenario.yaml:5: ego.lanes: "),
                    HasSubstr("'west-EW_5' is not in the network; the nearest is 'west-EW_")));
  const std::string words = check.err.substr(std::string("dadrl scenario: ").size());
  setenv("DADRL_SCENARIOS", folder_.path().c_str(), 1);
  const std::string run = folder_.path() / "run";
  const std::string picture = folder_.path() / "out.svg";
  const std::vector<std::vector<std::string>> commands = {
      {"train", "broken", "--run-dir", run},
      {"train", "broken", "--run-dir", run, "--deterministic"},
      {"train", "all", "--run-dir", run},
      {"collect", "broken", "--policy", "random", "--episodes", "1", "--out", run},
      {"evaluate", "--policy", "idm", "--scenario", "broken"},
      {"render", "--policy", "idm", "--scenario", "broken", "--out", picture}};
  for (const std::vector<std::string>& command : commands) {
    const CommandOutput output = Dadrl(command);
    EXPECT_EQ(output.exit_code, 2) << command.front();
    EXPECT_EQ(output.err, "dadrl " + command.front() + ": " + words);
  }
  EXPECT_FALSE(fs::exists(run));
  EXPECT_FALSE(fs::exists(picture));
}

TEST_F(ScenarioCommand, SpeaksJsonForEachThatItIsAsked) {
  const CommandOutput output = Dadrl({"scenario", "check", "--json", Broken(), "left_turn"});
  EXPECT_EQ(output.exit_code, 2);
  const size_t line = output.out.find('\n');
  const auto broken = nlohmann::json::parse(output.out.substr(0, line));
  EXPECT_EQ(broken["drivable"], false);
  EXPECT_THAT(broken["error"].get<std::string>(), HasSubstr("west-EW_5"));
  EXPECT_EQ(nlohmann::json::parse(output.out.substr(line + 1))["drivable"], true);
}

TEST_F(ScenarioCommand, WarnsOfWhatTheSettingsMakeImpossible) {
  const CommandOutput check = Dadrl({"scenario", "check", "left_turn", "--set", "task.max_speed_mps=1"});
  EXPECT_EQ(check.exit_code, 0);
  EXPECT_THAT(check.out, AllOf(HasSubstr("\nwarning   the goal cannot be reached: "),
                               HasSubstr("\nverdict   can be driven, see the warnings\n")));
  const CommandOutput drawn = Dadrl({"evaluate", "--policy", "idm", "--scenario", "left_turn", "--episodes",
                                     "1", "--seeds", "1", "--set", "task.max_speed_mps=1"});
  EXPECT_THAT(drawn.err, HasSubstr("dadrl evaluate: left_turn: the goal cannot be reached: "));
}

TEST_F(ScenarioCommand, KnowsItsWords) {
  EXPECT_THAT(Dadrl({"scenario", "chek"}).err, HasSubstr("unknown command 'chek'; the nearest is 'check'"));
  EXPECT_EQ(Dadrl({"scenario"}).exit_code, 2);
  EXPECT_EQ(Dadrl({"scenario", "check"}).exit_code, 2);
  EXPECT_EQ(Dadrl({"scenario", "check", "--help"}).exit_code, 0);
  EXPECT_THAT(Dadrl({"scenario", "check", "lft_turn"}).err, HasSubstr("the nearest is 'left_turn'"));
  EXPECT_THAT(Dadrl({"scenario", "check", "left_turn", "roundabout_a", "--picture", "x.svg"}).err,
              HasSubstr("--picture draws one scenario"));
}

}  // namespace
}  // namespace dadrl
