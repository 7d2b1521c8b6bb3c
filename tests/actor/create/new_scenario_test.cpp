// Folders made from networks, plain XML and maps: what is in them, and what is refused.
#include "actor/create/new_scenario.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "actor/check/scenario_check.h"
#include "tests/common/io/temporary_folder.h"
#include "tests/paths.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kTown = DADRL_SOURCE_DIR "/tests/actor/create/town.osm";
constexpr const char* kPlain = DADRL_SOURCE_DIR "/actor/scenarios/left_turn/network.nod.xml";

class NewScenario : public testing::Test {
 protected:
  NewScenarioOptions FromTown(const std::string& name, const std::string& from, const std::string& to) {
    return {.name = name, .net = {}, .osm = kTown, .from = from, .to = to, .into = folder_.path()};
  }
  // Its standard output; fails where it cannot be made.
  static std::string Make(const NewScenarioOptions& options) {
    testing::internal::CaptureStdout();
    const Result<int> made = RunNewScenario(options);
    const std::string output = testing::internal::GetCapturedStdout();
    EXPECT_TRUE(made) << made.error().message;
    return output;
  }
  static std::string Refusal(const NewScenarioOptions& options) {
    testing::internal::CaptureStdout();
    const Result<int> made = RunNewScenario(options);
    testing::internal::GetCapturedStdout();
    EXPECT_FALSE(made);
    return made ? "" : made.error().message;
  }
  CheckedScenario Check(const std::string& name) {
    Config config;
    config.scenario = name;
    auto checked = CheckScenario(config, folder_.path());
    EXPECT_TRUE(checked) << checked.error().message;
    return checked ? std::move(*checked) : CheckedScenario{};
  }
  std::vector<std::string> Entries() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_.path())) names.push_back(entry.path().filename());
    return names;
  }

  const TemporaryFolder folder_;
};

TEST_F(NewScenario, OfATownIsDrivenThroughItsTrafficLightsAndUnderItsBridge) {
  const std::string output = Make(FromTown("main_street", "100#0", "100#2"));
  EXPECT_THAT(output, AllOf(HasSubstr("1 traffic light"), HasSubstr("100#0_0 -> 100#1_0 -> 100#2_0"),
                            HasSubstr("dadrl train main_street")));
  const CheckedScenario checked = Check("main_street");
  EXPECT_THAT(checked.report.route.lanes, ElementsAre("100#0_0", "100#1_0", "100#2_0"));
  EXPECT_TRUE(checked.report.has_levels);
  // Whoever is on the bridge is 6 m above.
  const RoadMap& map = checked.environment->map();
  const auto& bridge = map.lane(map.FindLane("700_0"));
  EXPECT_DOUBLE_EQ(bridge.centre.ElevationAt(bridge.centre.length() / 2), 6.0);
  for (const TrafficFlow& flow : checked.scenario.flows) EXPECT_NE(flow.edges.front(), "100#0");
  EXPECT_GT(checked.scenario.flows.size(), 3u);
}

TEST_F(NewScenario, OfATownGoesRoundItsRoundaboutAgainstTheClock) {
  Make(FromTown("roundabout", "100#2", "600"));
  const CheckedScenario checked = Check("roundabout");
  // West in, south and east passed, north out: three quarters.
  EXPECT_THAT(checked.report.route.lanes, ElementsAre("100#2_0", "400#0_0", "400#1_0", "400#2_0", "600_0"));
}

TEST_F(NewScenario, KnowsOneWayStreets) {
  EXPECT_THAT(Refusal(FromTown("wrong_way", "-300", "-100#0")),
              AllOf(HasSubstr("--from: the network has no edge '-300'"), HasSubstr("'300'")));
  EXPECT_THAT(Refusal(FromTown("no_way", "-702", "100#0")),
              HasSubstr("no way leads from edge '-702' to edge '100#0'"));
  EXPECT_THAT(Refusal(FromTown("on_foot", "800", "100#0")), HasSubstr("no edge '800' that cars may use"));
  EXPECT_TRUE(Entries().empty());  // nothing half made
}

TEST_F(NewScenario, ListsTheEdgesWithTheirStreetsToWhoNamesNone) {
  EXPECT_THAT(Refusal(FromTown("which", "", "")),
              AllOf(HasSubstr("--from and --to are needed"), HasSubstr("300 Einbahngasse (")));
}

TEST_F(NewScenario, OfPlainXmlHasTheNetworkThatShips) {
  Make({.name = "t", .net = kPlain, .osm = {}, .from = "south-SN", .to = "west-EW", .into = folder_.path()});
  const CheckedScenario checked = Check("t");
  // Of the two lanes that the turn leads into, the nearer.
  EXPECT_THAT(checked.report.route.lanes, ElementsAre("south-SN_1", "west-EW_1"));
  const auto left_turn = LoadScenario("left_turn");
  ASSERT_TRUE(left_turn);
  const auto shipped = Simulation::Create(*left_turn, {});
  ASSERT_TRUE(shipped);
  const std::vector<Lane>& lanes = checked.environment->map().lanes();
  ASSERT_EQ(lanes.size(), (*shipped)->map().lanes().size());
  for (size_t i = 0; i < lanes.size(); ++i) {
    EXPECT_EQ(lanes[i].id, (*shipped)->map().lanes()[i].id);
    EXPECT_EQ(lanes[i].centre.length(), (*shipped)->map().lanes()[i].centre.length());
  }
}

TEST_F(NewScenario, OfANetworkCopiesIt) {
  const auto scenario = LoadScenario("double_merge");
  ASSERT_TRUE(scenario);
  Make({.name = "copy",
        .net = scenario->network,
        .osm = {},
        .from = scenario->flows[0].edges.front(),
        .to = scenario->flows[0].edges.back(),
        .into = folder_.path()});
  EXPECT_EQ(fs::file_size(folder_.path() / "copy/network.net.xml"), fs::file_size(scenario->network));
}

TEST_F(NewScenario, TakesNamesWithSpacesAndUmlautsAndQuotesThem) {
  EXPECT_THAT(Make(FromTown("grüne straße", "100#0", "100#1")), HasSubstr("dadrl train 'grüne straße'"));
  EXPECT_EQ(Check("grüne straße").report.name, "grüne straße");
}

TEST_F(NewScenario, RefusesNamesThatAreNoFoldersOfItsOwn) {
  const auto refusal = [&](const std::string& name) { return Refusal(FromTown(name, "100#0", "100#1")); };
  EXPECT_THAT(refusal("../out"), HasSubstr("has a '/' in it"));
  EXPECT_THAT(refusal("/tmp/out"), HasSubstr("has a '/' in it"));
  EXPECT_THAT(refusal(".."), HasSubstr("begins with '.'"));
  EXPECT_THAT(refusal("-x"), HasSubstr("begins with '-'"));
  EXPECT_THAT(refusal(""), HasSubstr("is empty"));
  EXPECT_THAT(refusal("all"), HasSubstr("stands for every scenario"));
  EXPECT_THAT(refusal("a\nb"), HasSubstr("characters in it that are not text"));
  EXPECT_THAT(refusal("a\xff"), HasSubstr("characters in it that are not text"));
  EXPECT_THAT(refusal(std::string(65, 'x')), HasSubstr("longer than 64 bytes"));
  EXPECT_TRUE(Entries().empty());
}

TEST_F(NewScenario, WritesOverNothing) {
  fs::create_directories(folder_.path() / "mine");
  std::ofstream(folder_.path() / "mine/notes.txt") << "keep";
  EXPECT_THAT(Refusal(FromTown("mine", "100#0", "100#1")), HasSubstr("is there already"));
  fs::create_symlink("/nowhere", folder_.path() / "dangling");
  EXPECT_THAT(Refusal(FromTown("dangling", "100#0", "100#1")), HasSubstr("is there already"));
  EXPECT_TRUE(fs::exists(folder_.path() / "mine/notes.txt"));
}

}  // namespace
}  // namespace dadrl
