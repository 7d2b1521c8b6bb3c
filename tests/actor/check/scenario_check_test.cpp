// What a check says of roads, and that what cannot be driven is refused with place and remedy.
#include "actor/check/scenario_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "actor/check/scenario_picture.h"
#include "tests/common/io/temporary_folder.h"
#include "tests/paths.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr const char* kRoads = DADRL_SOURCE_DIR "/tests/actor/roads";

Result<CheckedScenario> Check(const std::string& name, const fs::path& directory = ScenarioDirectory()) {
  Config config;
  config.scenario = name;
  return CheckScenario(config, directory);
}

std::string Text(const fs::path& file) {
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

TEST(ScenarioCheck, FindsNothingWrongWithTheScenariosThatShip) {
  for (const std::string& name : ScenarioNames()) {
    const auto checked = Check(name);
    ASSERT_TRUE(checked) << checked.error().message;
    EXPECT_THAT(checked->report.warnings, IsEmpty()) << name;
  }
}

// The length as in network_test.cpp.
TEST(ScenarioCheck, KnowsTheLeftTurn) {
  const auto checked = Check("left_turn");
  ASSERT_TRUE(checked) << checked.error().message;
  const ScenarioReport& report = checked->report;
  EXPECT_EQ(report.survey.roads, 5);
  EXPECT_EQ(report.survey.traffic_lights, 0);
  EXPECT_NEAR(report.route.length_m, 101.6, 1.0);
  EXPECT_EQ(report.route.junctions, 1);
  EXPECT_EQ(report.route.lane_changes, 0);
  EXPECT_NEAR(report.route.shortest_s, 10.2, 0.1);
  ASSERT_EQ(report.flows.size(), 5u);
  for (const FlowFacts& flow : report.flows) EXPECT_TRUE(flow.meets_route);
  EXPECT_GT(report.cost.memory_bytes, 10e6);
  EXPECT_THAT(ReportText(report),
              AllOf(HasSubstr("south-SN_1 -> west-EW_0: 10"), HasSubstr("can be driven")));
  const auto json = nlohmann::json::parse(ReportJson(report));
  EXPECT_EQ(json["drivable"], true);
  EXPECT_EQ(json["traffic"]["vehicles"], 20);
  EXPECT_EQ(json["route"]["junctions"], 1);
}

TEST(ScenarioCheck, SaysWhatOfTheRoadIsIgnored) {
  const auto crosswalks = Check("crosswalks", kRoads);
  ASSERT_TRUE(crosswalks) << crosswalks.error().message;
  EXPECT_EQ(crosswalks->report.survey.ignored.at("pavement"), 8);  // one beside each road
  EXPECT_GT(crosswalks->report.survey.ignored.at("crossing"), 0);
  const auto cycle_lane = Check("cycle_lane", kRoads);
  ASSERT_TRUE(cycle_lane) << cycle_lane.error().message;
  EXPECT_THAT(ReportText(cycle_lane->report), HasSubstr("cycle lane"));
}

TEST(ScenarioCheck, DrawsRouteStartGoalAndTraffic) {
  const auto checked = Check("left_turn");
  ASSERT_TRUE(checked);
  ASSERT_TRUE(checked->environment->Reset(checked->seed));
  const std::string svg = ScenarioPicture(*checked->environment, checked->scenario);
  EXPECT_THAT(svg, AllOf(HasSubstr("class=\"route\""), HasSubstr(">start<"), HasSubstr(">goal<"),
                         HasSubstr("class=\"flow\""), HasSubstr("class=\"car\"")));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
}

// The left turn, with one thing changed.
class ScenarioFault : public testing::Test {
 protected:
  ScenarioFault() {
    const Scenario scenario = LoadScenario("left_turn").value();
    fs::create_directories(folder_.path() / "mine");
    yaml_ = Text(scenario.file);
    fs::copy_file(scenario.network, network());
  }
  fs::path network() const { return folder_.path() / "mine/network.net.xml"; }
  std::string With(const std::string& from, const std::string& to) {
    std::string yaml = yaml_;
    const size_t at = yaml.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    yaml.replace(at, from.size(), to);
    return WithYaml(yaml);
  }
  std::string WithYaml(const std::string& yaml) {
    std::ofstream(folder_.path() / "mine/scenario.yaml") << yaml;
    const auto checked = Check("mine", folder_.path());
    EXPECT_FALSE(checked);
    if (checked) return "";
    EXPECT_EQ(checked.error().code, ErrorCode::kInvalidArgument) << checked.error().message;
    EXPECT_EQ(checked.error().message.find('\n'), std::string::npos) << checked.error().message;
    return checked.error().message;
  }
  std::string WithNetwork(const std::string& text) {
    std::ofstream(network(), std::ios::trunc) << text;
    return WithYaml(yaml_);
  }

  const TemporaryFolder folder_;
  std::string yaml_;
};

TEST_F(ScenarioFault, InTheEgosWayIsNamedWithWhatThereIs) {
  EXPECT_THAT(With("south-SN_1, west", "south-SN_7, west"),
              AllOf(HasSubstr("mine/scenario.yaml:"), HasSubstr("ego.lanes: lane 'south-SN_7' is not in the "
                                                                "network; the nearest is 'south-SN_")));
  EXPECT_THAT(With("south-SN_1, west-EW_0", "south-SN_1, east-WE_0"),
              AllOf(HasSubstr("no connection leads from lane 'south-SN_1' to lane 'east-WE_0'"),
                    HasSubstr("it leads to: "), HasSubstr("west-EW_")));
  EXPECT_THAT(With("start_offset_m: 40", "start_offset_m: 4000"),
              HasSubstr("4000 exceeds lane 'south-SN_1'"));
}

TEST_F(ScenarioFault, InAFlowIsNamedWithItsLine) {
  EXPECT_THAT(With("west-WE, east-WE", "west-WE, est-WE"),
              AllOf(HasSubstr("mine/scenario.yaml:10: traffic.flows: edge 'est-WE' is not in the network"),
                    HasSubstr("nearest is 'east-WE'")));
  EXPECT_THAT(
      With("west-WE, east-WE", "west-WE, west-EW"),
      HasSubstr("edge 'west-WE' does not lead into 'west-EW' for vClass passenger; it leads into: east-WE"));
  EXPECT_THAT(With("depart_lane: 0", "depart_lane: 9"), HasSubstr("has no lane 9; its lanes are 0 to 1"));
}

TEST_F(ScenarioFault, OfANetworkNamesTheFileAndWhoMakesOne) {
  const auto refused = AllOf(HasSubstr("mine/network.net.xml is not a network that netconvert wrote"),
                             HasSubstr("dadrl scenario new"));
  EXPECT_THAT(WithNetwork(""), refused);
  EXPECT_THAT(WithNetwork("hello"), refused);
  EXPECT_THAT(WithNetwork("<nodes/>"), refused);
  EXPECT_THAT(WithNetwork("<net version=\"1.9\"><edge id=\"a\" "), refused);
  fs::remove(network());
  fs::create_directory(network());
  EXPECT_THAT(WithYaml(yaml_), refused);
}

// Half of the way would be driven beside the road.
TEST_F(ScenarioFault, OfANetworkWithoutLanesInsideItsJunctionsIsNamed) {
  const std::string bare = folder_.path() / "bare.net.xml";
  const std::string command = "netconvert -s '" + network().string() + "' -o '" + bare +
                              "' --no-internal-links true --xml-validation never >/dev/null 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0);
  EXPECT_THAT(WithNetwork(Text(bare)), AllOf(HasSubstr("without a lane"), HasSubstr("--no-internal-links")));
}

// The left turn with the arm in the south called otherwise.
TEST_F(ScenarioFault, OfANameThatSumoCannotReadInARouteIsNamed) {
  std::string text = Text(network());
  for (size_t at = 0; (at = text.find("south-SN", at)) != std::string::npos; ++at) {
    text.replace(at, 8, "s\u00fcd-SN");
  }
  for (size_t at = 0; (at = yaml_.find("south-SN", at)) != std::string::npos; ++at) {
    yaml_.replace(at, 8, "s\u00fcd-SN");
  }
  EXPECT_THAT(WithNetwork(text), HasSubstr("SUMO cannot read a route over edge 's\u00fcd-SN'"));
}

// The first of the flow stands where the ego starts, and creeps.
TEST_F(ScenarioFault, OfAStartThatStaysBlockedIsNamed) {
  const auto edit = [&](const std::string& from, const std::string& to) {
    ASSERT_NE(yaml_.find(from), std::string::npos) << from;
    yaml_.replace(yaml_.find(from), from.size(), to);
  };
  edit("start_offset_m: 40", "start_offset_m: 53");
  edit("[south-SN, east-WE], depart_lane: 0, arrival_lane: 0, depart: random",
       "[south-SN, west-EW], depart_lane: 1, arrival_lane: 0, depart: lane_end");
  edit("actionStepLength: 0.5", "maxSpeed: 0.001");
  EXPECT_THAT(
      WithYaml(yaml_),
      HasSubstr("the ego's start stayed blocked for 60 s, in each of 3 episodes; keep the start free"));
}

}  // namespace
}  // namespace dadrl
