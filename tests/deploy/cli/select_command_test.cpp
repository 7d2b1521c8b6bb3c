// `dadrl select` on run directories made of shipped policies.
#include <gmock/gmock.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/config/config_yaml.h"
#include "common/model/policy_file.h"
#include "deploy/local/run_directory.h"
#include "tests/deploy/cli/run_command.h"
#include "tests/paths.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class SelectCommand : public testing::Test {
 protected:
  // A run whose trained policy, of 100 updates, was followed by one that has forgotten everything.
  SelectCommand() {
    const auto run = RunDirectory::CreateNew(paths_.root);
    EXPECT_TRUE(run && run->SaveConfig(Config{}));
    const auto trained = LoadPolicy(DADRL_SOURCE_DIR "/deploy/policies/left_turn.dadrl");
    EXPECT_TRUE(trained) << trained.error().message;
    Save(*trained, 100, trained->policy().parameters);
    Save(*trained, 200, std::vector<float>(trained->policy().parameters.size()));
    fs::create_symlink("policy-000000200.dadrl", paths_.policy());
  }

  void Save(const PolicyFile& policy, uint64_t updates, const std::vector<float>& parameters) const {
    EXPECT_TRUE(SavePolicy(paths_.checkpoints() / fmt::format("policy-{:09}.dadrl", updates),
                           {.updates = updates,
                            .config_yaml = ToYaml(policy.config, false),
                            .networks = {{kPolicyNetwork, policy.policy().layout_hash, parameters}}}));
  }
  CommandOutput Select(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"select", "--run-dir", paths_.root, "--episodes", "4", "--processes", "1"});
    return Dadrl(more, 240);
  }

  const TemporaryFolder folder_;
  const RunPaths paths_{.root = folder_.path() / "run"};
};

TEST_F(SelectCommand, TakesTheBetterPolicyAndSaysSoTwice) {
  const CommandOutput output = Select({"--json"});
  ASSERT_EQ(output.exit_code, 0) << output.err;
  EXPECT_EQ(output.out, FileText(paths_.selection()));
  const json record = json::parse(output.out);
  EXPECT_EQ(record["updates"], 100);
  EXPECT_EQ(record["scenario"], "left_turn");
  ASSERT_EQ(record["candidates"].size(), 2u);
  EXPECT_GT(record["candidates"][1]["success"], record["candidates"][0]["success"]);
  EXPECT_EQ(LoadPolicy(paths_.best_policy())->updates, 100u);
  EXPECT_EQ(LoadPolicy(paths_.policy())->updates, 200u);

  EXPECT_EQ(Select({"--json"}).out, output.out);
}

TEST_F(SelectCommand, LooksOnlyAtTheNewestCandidatesAsked) {
  const CommandOutput output = Select({"--candidates", "1"});
  ASSERT_EQ(output.exit_code, 0) << output.err;
  EXPECT_THAT(output.out, AllOf(HasSubstr("left_turn: 4 episodes each"), HasSubstr("chosen"),
                                HasSubstr(paths_.best_policy().string())));
  EXPECT_EQ(LoadPolicy(paths_.best_policy())->updates, 200u);
}

TEST_F(SelectCommand, LeavesARunInUseAlone) {
  const auto holder = RunDirectory::OpenExisting(paths_.root);
  ASSERT_TRUE(holder);
  const CommandOutput output = Select();
  EXPECT_EQ(output.exit_code, 1);
  EXPECT_THAT(output.out, IsEmpty());
  EXPECT_THAT(output.err, HasSubstr("in use by another dadrl"));
  EXPECT_FALSE(fs::exists(paths_.selection()));
}

TEST_F(SelectCommand, SaysInOneLineThatThereIsNoPolicy) {
  for (const char* name : {"policy-000000100.dadrl", "policy-000000200.dadrl"}) {
    fs::remove(paths_.checkpoints() / name);
  }
  const CommandOutput output = Select();
  EXPECT_EQ(output.exit_code, 1);
  EXPECT_THAT(output.out, IsEmpty());
  EXPECT_THAT(output.err, HasSubstr("holds no whole policy"));
  EXPECT_EQ(std::count(output.err.begin(), output.err.end(), '\n'), 1) << output.err;
}

}  // namespace
}  // namespace dadrl
