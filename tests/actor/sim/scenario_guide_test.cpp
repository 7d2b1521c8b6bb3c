// docs/scenarios.md is right: its files, taken from the page, become a scenario by its own commands.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "actor/sim/simulation.h"
#include "tests/paths.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

// The text of the first fenced block after `heading`.
std::string BlockAfter(const std::string& page, const std::string& heading) {
  const size_t begin = page.find('\n', page.find("\n```", page.find(heading)) + 1) + 1;
  return page.substr(begin, page.find("```", begin) - begin);
}

class ScenarioGuide : public testing::Test {
 protected:
  void SetUp() override {
    std::stringstream text;
    text << std::ifstream(DADRL_SOURCE_DIR "/docs/scenarios.md").rdbuf();
    const std::string page = text.str();
    fs::create_directories(folder_);
    for (const char* name : {"network.nod.xml", "network.edg.xml", "network.con.xml", "scenario.yaml"}) {
      std::ofstream(folder_ / name) << BlockAfter(page, std::string("\n`") + name + "`");
    }
    std::ofstream(folder_ / "steps.sh") << BlockAfter(page, "replaces the built ones:");
    const std::string command = "cd '" + folder_.string() + "' && bash -e steps.sh >steps.log 2>&1";
    ASSERT_EQ(std::system(command.c_str()), 0) << std::ifstream(folder_ / "steps.log").rdbuf();
  }
  void TearDown() override { fs::remove_all(folder_); }

  const fs::path folder_ = fs::path(testing::TempDir()) / "scenario_guide";
};

TEST_F(ScenarioGuide, ItsExampleCanBeDriven) {
  const auto scenario = LoadScenario("on_ramp", folder_ / "my_scenarios");
  ASSERT_TRUE(scenario) << scenario.error().message;
  EXPECT_EQ(scenario->population(), 16);
  SimulationOptions options;
  options.ego_driver = EgoDriver::kSumo;
  const auto created = Simulation::Create(*scenario, options);
  ASSERT_TRUE(created) << created.error().message;
  Simulation& simulation = **created;
  ASSERT_TRUE(simulation.Reset(1));
  EXPECT_GT(simulation.world().vehicles.size(), 4u);
  int steps = 0;
  for (; !simulation.ego_arrived() && steps < 800; ++steps) ASSERT_TRUE(simulation.StepSumoDriver());
  EXPECT_TRUE(simulation.ego_arrived());
  EXPECT_LT(Norm(simulation.world().ego.pose.position - simulation.route().goal()), 2.0);
}

}  // namespace
}  // namespace dadrl
