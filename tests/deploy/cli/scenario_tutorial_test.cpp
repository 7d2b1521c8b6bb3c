// docs/scenarios.md is right: its files and its commands, taken from the page, in its order.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <string>

#include "tests/deploy/cli/run_command.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// From `at` on, the text of the next fenced block that begins with `fence`; moves `at` behind it.
std::string NextBlock(const std::string& page, const std::string& fence, size_t& at) {
  const size_t found = page.find("\n" + fence, at);
  if (found == std::string::npos) return {};
  const size_t begin = page.find('\n', found + 1) + 1;
  const size_t end = page.find("\n```", begin - 1) + 1;
  at = end + 3;
  return page.substr(begin, end - begin);
}

// What a test can afford, of the same commands.
std::string WithSmallBudget(std::string commands) {
  const auto replace = [&](const char* pattern, const char* by) {
    commands = std::regex_replace(commands, std::regex(pattern), by);
  };
  replace("--episodes 20", "--episodes 1");
  replace(
      "--minutes 20",
      "--minutes 4 --actors 1 --set learner.max_updates=40 --set replay.min_size=200 --set model.hidden=32 "
      "--set evaluation.interval_s=0 --set evaluation.episodes=1 --set evaluation.candidates=1");
  return commands;
}

TEST(ScenarioTutorial, ItsCommandsLeadFromARoadToAPolicyAndItsPicture) {
  const std::string page = FileText(DADRL_SOURCE_DIR "/docs/scenarios.md");
  const TemporaryFolder folder;
  for (const char* name : {"network.nod.xml", "network.edg.xml", "network.con.xml", "scenario.yaml"}) {
    size_t at = page.find(std::string("\n`") + name + "`");
    ASSERT_NE(at, std::string::npos) << name;
    std::ofstream(folder.path() / name) << NextBlock(page, "```", at);
  }
  fs::copy_file(DADRL_SOURCE_DIR "/tests/actor/create/town.osm", folder.path() / "map.osm");
  std::string commands =
      "set -ex\ncd '" + folder.path().string() + "'\nPATH=" DADRL_BINARY_DIR "/bin:$PATH\n";
  int blocks = 0;
  size_t at = 0;
  for (std::string block; !(block = NextBlock(page, "```bash", at)).empty(); ++blocks) commands += block;
  EXPECT_EQ(blocks, 5);
  std::ofstream(folder.path() / "steps.sh") << WithSmallBudget(commands);
  const CommandOutput output = RunCommand({"/bin/bash", folder.path() / "steps.sh"}, 400);
  EXPECT_EQ(output.exit_code, 0) << output.out << output.err;
  for (const char* made :
       {"scenarios/on_ramp/network.net.xml", "scenarios/main_street/scenario.yaml", "on_ramp.svg",
        "runs/on_ramp/results.json", "on_ramp_episode.svg", "on_ramp_episode.png"}) {
    EXPECT_TRUE(fs::exists(folder.path() / made)) << made;
  }
  EXPECT_THAT(FileText(folder.path() / "on_ramp.svg"), HasSubstr(">goal<"));
}

}  // namespace
}  // namespace dadrl
