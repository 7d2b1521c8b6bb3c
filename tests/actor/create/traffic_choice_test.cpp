#include "actor/create/traffic_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "actor/create/lane_search.h"
#include "actor/create/scenario_yaml.h"

namespace dadrl {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Lane MakeLane(const std::string& edge, int index, Point from, Point to) {
  Lane lane;
  lane.id = edge + "_" + std::to_string(index);
  lane.edge = edge;
  lane.index = index;
  lane.speed_limit = 13.9;
  lane.centre = Polyline({from, to});
  return lane;
}

// Two lanes eastward, a minor road into the right one, which ends behind the junction; the left goes on to
// the goal. 120 m each.
RoadMap Merge() {
  std::vector<Lane> lanes{
      MakeLane("in", 0, {0, 0}, {120, 0}),        MakeLane("in", 1, {0, 3.2}, {120, 3.2}),
      MakeLane("side", 0, {40, -120}, {120, 0}),  MakeLane("out", 0, {120, 0}, {240, 0}),
      MakeLane("out", 1, {120, 3.2}, {240, 3.2}), MakeLane("on", 0, {240, 3.2}, {360, 3.2})};
  lanes[0].successors = {3};
  lanes[1].successors = {4};
  lanes[2].successors = {3};
  lanes[4].successors = {5};
  return RoadMap(std::move(lanes), {});
}

TEST(LaneSearch, ChangesLanesWhereNoneLeadsOn) {
  const RoadMap map = Merge();
  EXPECT_THAT(FindLanes(map, "side", "on").value(), ElementsAre("side_0", "out_0", "out_1", "on_0"));
  // Without a change where another lane of the first edge leads on.
  EXPECT_THAT(FindLanes(map, "in", "on").value(), ElementsAre("in_1", "out_1", "on_0"));
  EXPECT_THAT(FindLanes(map, "in", "in").value(), ElementsAre("in_0"));
}

TEST(LaneSearch, NamesWhatIsNotThereAndWhereNoWayLeads) {
  const RoadMap map = Merge();
  EXPECT_THAT(FindLanes(map, "sid", "on").error().message, HasSubstr("nearest names are 'side'"));
  EXPECT_THAT(FindLanes(map, "", "on").error().message, HasSubstr("--from"));
  EXPECT_THAT(FindLanes(map, "side", ":J").error().message, HasSubstr("--to"));
  EXPECT_THAT(FindLanes(map, "on", "side").error().message, HasSubstr("no way leads from edge 'on' to edge"));
  EXPECT_THAT(FindLanes(RoadMap({}, {}), "a", "b").error().message, HasSubstr("no lane that cars may use"));
}

TEST(TrafficChoice, ComesFromTheOtherRoadsIntoTheRoute) {
  const RoadMap map = Merge();
  const TrafficChoice choice = ChooseTraffic(map, FindLanes(map, "side", "on").value());
  ASSERT_EQ(choice.flows.size(), 2u);
  EXPECT_THAT(choice.flows[0].edges, ElementsAre("in", "out"));
  EXPECT_THAT(choice.flows[1].edges, ElementsAre("out", "on"));
  // 120 m of lane each: 2 of in, 2 of out, 1 of on make 600 m, 20 vehicles, at most 8 a flow.
  EXPECT_EQ(choice.driver_types, 8);
}

TEST(ScenarioYaml, QuotesNamesThatYamlReadsAsSomethingElse) {
  Scenario scenario;
  scenario.ego_lanes = {"-100#0_0", "plain_0", "it's", "12"};
  const std::string yaml = ScenarioYaml(scenario, "first");
  EXPECT_THAT(yaml, HasSubstr("lanes: ['-100#0_0', plain_0, 'it''s', '12']"));
  EXPECT_THAT(yaml, HasSubstr("flows: []"));
}

}  // namespace
}  // namespace dadrl
