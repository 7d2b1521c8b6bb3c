// The built networks against the published geometry and right of way.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <regex>
#include <sstream>

#include "actor/sim/simulation.h"

namespace dadrl {
namespace {

using testing::ElementsAre;
using testing::UnorderedElementsAre;

struct Expected {
  std::string scenario;
  double route_m;
  Point start_front;
  double start_heading_deg;
  Point goal;
  double limit_mps;
};

void PrintTo(const Expected& expected, std::ostream* out) { *out << expected.scenario; }

class Network : public testing::TestWithParam<Expected> {};

TEST_P(Network, EgoRouteIsThePublishedOne) {
  const Expected& expected = GetParam();
  const auto scenario = LoadScenario(expected.scenario);
  ASSERT_TRUE(scenario) << scenario.error().message;
  const auto simulation = Simulation::Create(*scenario, {});
  ASSERT_TRUE(simulation) << simulation.error().message;
  const Route& route = (*simulation)->route();
  EXPECT_NEAR(route.length(), expected.route_m, 0.01 * expected.route_m);
  EXPECT_NEAR(route.goal().x, expected.goal.x, 0.02);
  EXPECT_NEAR(route.goal().y, expected.goal.y, 0.02);

  ASSERT_TRUE((*simulation)->Reset(1));
  const EgoState& ego = (*simulation)->world().ego;
  const Point front = ego.pose.position + (kVehicleLength / 2) * Forward(ego.pose.heading);
  EXPECT_NEAR(front.x, expected.start_front.x, 0.02);
  EXPECT_NEAR(front.y, expected.start_front.y, 0.02);
  EXPECT_NEAR(WrapAngle(ego.pose.heading - expected.start_heading_deg * std::numbers::pi / 180), 0.0, 0.006);
  EXPECT_DOUBLE_EQ(ego.speed_mps, 10.0);
  const auto position = (*simulation)->map().NearestLane(front, ego.pose.heading, 3.2);
  ASSERT_TRUE(position);
  EXPECT_DOUBLE_EQ((*simulation)->map().lanes()[static_cast<size_t>(position->lane)].speed_limit,
                   expected.limit_mps);
}

INSTANTIATE_TEST_SUITE_P(
    Scenarios, Network,
    testing::Values(Expected{"left_turn", 101.6, {39.46, 25.66}, 90, {-35.99, 55.01}, 13.89},
                    Expected{"roundabout_a", 111.9, {147.83, 73.57}, 180, {77.11, 140.63}, 13.89},
                    Expected{"roundabout_b", 200.0, {147.83, 73.57}, 180, {0.02, 73.02}, 13.89},
                    Expected{"roundabout_c", 278.6, {147.83, 73.57}, 180, {74.33, -0.01}, 13.89},
                    Expected{"double_merge", 168.9, {18.68, 66.40}, -34.3, {182.66, 46.61}, 13.89}),
    [](const auto& test) { return test.param.scenario; });

// The .net.xml as netconvert wrote it.
std::string NetworkText(const std::string& scenario) {
  std::stringstream text;
  text << std::ifstream(LoadScenario(scenario).value().network).rdbuf();
  return text.str();
}

std::map<std::string, int> LanesPerEdge(const std::string& text) {
  std::map<std::string, int> lanes;
  const std::regex lane(R"re(<lane id="([^:"][^"]*)_\d+")re");
  for (std::sregex_iterator it(text.begin(), text.end(), lane), end; it != end; ++it) ++lanes[(*it)[1]];
  return lanes;
}

// Responses of one junction in link order; '1' at place i counted from the right: yields to link i.
std::vector<std::string> Responses(const std::string& text, const std::string& junction) {
  const size_t begin = text.find("<junction id=\"" + junction + "\"");
  const std::string part = text.substr(begin, text.find("</junction>", begin) - begin);
  std::vector<std::string> responses;
  const std::regex request(R"re(<request index="\d+" response="([01]+)")re");
  for (std::sregex_iterator it(part.begin(), part.end(), request), end; it != end; ++it) {
    responses.push_back((*it)[1]);
  }
  return responses;
}

TEST(LaneCounts, ArePublishedOnes) {
  using Counts = std::map<std::string, int>;
  EXPECT_EQ(LanesPerEdge(NetworkText("left_turn")),
            (Counts{{"east-EW", 2}, {"west-EW", 2}, {"west-WE", 2}, {"east-WE", 2}, {"south-SN", 2}}));
  EXPECT_EQ(LanesPerEdge(NetworkText("roundabout_a")), (Counts{{"east-EN", 2},
                                                               {"north-NW", 2},
                                                               {"west-WS", 2},
                                                               {"south-SE", 2},
                                                               {"east-EW", 1},
                                                               {"east-WE", 1},
                                                               {"north-NS", 1},
                                                               {"north-SN", 1},
                                                               {"west-WE", 1},
                                                               {"west-EW", 1},
                                                               {"south-SN", 1},
                                                               {"south-NS", 1}}));
  EXPECT_EQ(LanesPerEdge(NetworkText("double_merge")),
            (Counts{{"E17", 1}, {"E22", 1}, {"E5", 2}, {"E23", 1}, {"E24", 1}}));
}

TEST(RightOfWay, LeftTurnYieldsToTheMainRoad) {
  EXPECT_THAT(Responses(NetworkText("left_turn"), "J"),
              ElementsAre("0000000", "0000000", "1100000", "1100011", "1100011", "0000000", "0000000"));
}

TEST(RightOfWay, RoundaboutEntriesYieldToTheRing) {
  const std::string text = NetworkText("roundabout_a");
  for (const char* junction : {"jE", "jN", "jS"}) {
    EXPECT_THAT(Responses(text, junction),
                ElementsAre("001000", "101000", "000000", "000000", "001100", "000000"))
        << junction;
  }
  // The west node holds the same in another link order: ring first, then the entries.
  EXPECT_THAT(Responses(text, "jW"), ElementsAre("000000", "000000", "000011", "000000", "000010", "001010"));
}

TEST(RightOfWay, DoubleMergeHasNoConflicts) {
  const std::string text = NetworkText("double_merge");
  EXPECT_THAT(Responses(text, "J3"), ElementsAre("00", "00"));
  EXPECT_THAT(Responses(text, "J7"), ElementsAre("00", "00"));
}

TEST(Network, ForksAndSplitLanesAreConnected) {
  const auto simulation = Simulation::Create(LoadScenario("roundabout_a").value(), {});
  ASSERT_TRUE(simulation);
  const RoadMap& map = (*simulation)->map();
  EXPECT_EQ(map.lanes().size(), 44u);
  EXPECT_EQ(map.junctions().size(), 4u);
  // Two branches into the ring; the exit from the inner lane waits half way, in two pieces.
  const auto entry = ConnectLanes(map, {"east-EW_0", "east-EN_1"});
  EXPECT_EQ(entry.value().size(), 3u);
  const auto exit = ConnectLanes(map, {"east-EN_1", "north-SN_0"});
  EXPECT_EQ(exit.value().size(), 4u);
  for (const Lane& lane : map.lanes()) {
    for (const int next : lane.successors) {
      const Point from = lane.centre.points().back();
      const Point to = map.lanes()[static_cast<size_t>(next)].centre.points().front();
      EXPECT_LT(Norm(to - from), 0.05) << lane.id;
    }
  }
}

}  // namespace
}  // namespace dadrl
