#include "actor/ego/paths.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "actor/sim/simulation.h"
#include "tests/actor/ego/road_fixture.h"

namespace dadrl {
namespace {

using testing::UnorderedElementsAre;

// The paths of a scenario as "lane lane ..." without the lanes inside junctions; the route's own comes first.
std::vector<std::string> PathsOf(const std::string& scenario) {
  const auto simulation = Simulation::Create(LoadScenario(scenario).value(), {}).value();
  const RoadMap& map = simulation->map();
  auto paths = FindPaths(map, simulation->route());
  std::swap(paths[0], paths[static_cast<size_t>(PathOfRoute(paths, simulation->route()))]);
  std::vector<std::string> names;
  for (const Path& path : paths) {
    std::string name;
    for (const int lane : path.lanes) {
      const Lane& it = map.lanes()[static_cast<size_t>(lane)];
      if (!it.internal) name += (name.empty() ? "" : " ") + it.id;
    }
    names.push_back(name);
  }
  return names;
}

TEST(Paths, LeftTurnOffersBothTargetLanesAndTheRightTurn) {
  const auto paths = PathsOf("left_turn");
  EXPECT_EQ(paths.front(), "south-SN_1 west-EW_0");
  EXPECT_THAT(paths, UnorderedElementsAre("south-SN_1 west-EW_0", "south-SN_1 west-EW_1",
                                          "south-SN_0 east-WE_0", "east-WE_1"));
}

TEST(Paths, RoundaboutOffersBothRings) {
  const auto paths = PathsOf("roundabout_b");
  EXPECT_EQ(paths.front(), "east-EW_0 east-EN_0 north-NW_0 west-EW_0");
  EXPECT_THAT(paths, UnorderedElementsAre("east-EW_0 east-EN_0 north-NW_0 west-EW_0",
                                          "east-EW_0 east-EN_1 north-NW_1 west-EW_0"));
}

TEST(Paths, DoubleMergeOffersTheLaneThatIsReachedOnlyByALaneChange) {
  const auto paths = PathsOf("double_merge");
  EXPECT_EQ(paths.front(), "E17_0 E5_1 E24_0");
  EXPECT_THAT(paths, UnorderedElementsAre("E17_0 E5_1 E24_0", "E5_0 E23_0"));
}

// Thirty edges in a row, two lanes each, every lane leading into both of the next edge: 2^29 ways, but only
// two branches at each of 29 forks.
TEST(Paths, AsManyAsBranchesNotAsWays) {
  constexpr int kEdges = 30;
  std::vector<Lane> lanes;
  for (int edge = 0; edge < kEdges; ++edge) {
    for (int index = 0; index < 2; ++index) {
      const double y = 3.2 * index;
      std::vector<int> next;
      if (edge + 1 < kEdges) next = {2 * edge + 2 + index, 2 * edge + 3 - index};
      lanes.push_back(MakeLane(fmt::format("e{}_{}", edge, index), index,
                               {{100.0 * edge, y}, {100.0 * edge + 100.0, y}}, next));
    }
  }
  const RoadMap map(std::move(lanes), {});
  std::vector<int> way;
  for (int edge = 0; edge < kEdges; ++edge) way.push_back(2 * edge);
  const Route route(map, way, {0, 0}, {100.0 * kEdges, 0});
  const std::vector<Path> paths = FindPaths(map, route);
  EXPECT_LE(paths.size(), 2u * kEdges);
  EXPECT_EQ(paths[static_cast<size_t>(PathOfRoute(paths, route))].lanes, way);
  std::set<int> covered;
  for (const Path& path : paths) covered.insert(path.lanes.begin(), path.lanes.end());
  EXPECT_EQ(covered.size(), map.lanes().size());
}

}  // namespace
}  // namespace dadrl
