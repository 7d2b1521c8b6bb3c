#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/deploy/cli/run_command.h"
#include "tests/paths.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Three episodes of left_turn.
nlohmann::json Evaluate(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"evaluate", "--scenario", "left_turn", "--episodes", "3", "--seeds",
                                       "1", "--processes", "1", "--json"});
  const CommandOutput output = Dadrl(arguments, 240);
  EXPECT_EQ(output.exit_code, 0) << output.err;
  return nlohmann::json::parse(output.out);
}

TEST(EvaluateCommand, HoldChangesTheRandomDriver) {
  const auto standard = Evaluate({"--policy", "random"});
  EXPECT_EQ(standard, Evaluate({"--policy", "random", "--hold", "10"}));
  EXPECT_NE(standard, Evaluate({"--policy", "random", "--hold", "40"}));
}

TEST(EvaluateCommand, ImpatienceChangesSumosDriver) {
  const auto standard = Evaluate({"--policy", "idm"});
  EXPECT_EQ(standard, Evaluate({"--policy", "idm", "--impatience", "1"}));
  EXPECT_NE(standard, Evaluate({"--policy", "idm", "--impatience", "0"}));
}

// A folder of scenarios with one in it, a copy of left_turn, for the commands of this process.
class BrokenScenario : public testing::Test {
 protected:
  BrokenScenario() {
    fs::copy(DADRL_BINARY_DIR "/share/dadrl/scenarios/left_turn", mine_, fs::copy_options::recursive);
    setenv("DADRL_SCENARIOS", folder_.path().c_str(), 1);
  }
  ~BrokenScenario() override { unsetenv("DADRL_SCENARIOS"); }

  // Exit code 1 or 2, one line, and nothing on standard output.
  std::string Refusal() {
    const CommandOutput output =
        Dadrl({"evaluate", "--policy", "rdm", "--scenario", "mine", "--episodes", "1", "--seeds", "1"}, 120);
    EXPECT_THAT(output.exit_code, testing::AnyOf(1, 2));
    EXPECT_THAT(output.out, IsEmpty());
    return output.err;
  }
  void Replace(const std::string& file, const std::string& from, const std::string& to) {
    std::string text = FileText(mine_ / file);
    const size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos);
    std::ofstream(mine_ / file) << text.replace(at, from.size(), to);
  }

  const TemporaryFolder folder_;
  const fs::path mine_ = folder_.path() / "mine";
};

TEST_F(BrokenScenario, AWrongKeyIsNamedWithFileAndLine) {
  Replace("scenario.yaml", "warm_up_s:", "warmup_s:");
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("mine/scenario.yaml:3: "), HasSubstr("'warm_up_s'")));
}

TEST_F(BrokenScenario, BrakingThatAbortsSumoIsNamed) {
  Replace("scenario.yaml", "emergencyDecel: 5.0", "emergencyDecel: 4.5");
  EXPECT_THAT(Refusal(), AllOf(HasSubstr("mine/scenario.yaml:19: "), HasSubstr("more than 4.5")));
}

TEST_F(BrokenScenario, ATornNetworkIsNamed) {
  const auto network = mine_ / "network.net.xml";
  fs::resize_file(network, fs::file_size(network) / 2);
  EXPECT_THAT(Refusal(), HasSubstr(network.string()));
}

TEST_F(BrokenScenario, ARouteThatTheNetworkDoesNotHaveIsNamed) {
  Replace("scenario.yaml", "west-EW_0]", "west-EW_7]");
  EXPECT_THAT(Refusal(), HasSubstr("ego.lanes: lane 'west-EW_7' is not in the network"));
}

}  // namespace
}  // namespace dadrl
