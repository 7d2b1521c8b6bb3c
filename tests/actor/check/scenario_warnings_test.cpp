#include "actor/check/scenario_warnings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dadrl {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// Nothing is wrong with it.
ScenarioReport GoodReport() {
  ScenarioReport report;
  report.max_speed_mps = 10.0;
  report.time_limit_s = 80.0;
  report.route = {.lanes = {"a_0", "b_0"}, .length_m = 300, .max_limit_mps = 13.9, .shortest_s = 30.0};
  report.flows = {{.edges = {"c"}, .vehicles = 8, .entered = 6, .meets_route = true}};
  return report;
}

TEST(ScenarioWarnings, AreNoneWhereNothingIsWrong) { EXPECT_THAT(WarningsOf(GoodReport()), IsEmpty()); }

TEST(ScenarioWarnings, NameAGoalThatNoEpisodeReaches) {
  ScenarioReport report = GoodReport();
  report.route.length_m = 851;
  report.route.shortest_s = 85.1;
  EXPECT_THAT(WarningsOf(report),
              ElementsAre(HasSubstr("851 m take 85 s at task.max_speed_mps=10, an episode "
                                    "ends after 80 s; give --set task.max_steps=1710")));
}

TEST(ScenarioWarnings, NameTrafficThatIsFasterThanTheEgoMayBe) {
  ScenarioReport report = GoodReport();
  report.route.max_limit_mps = 36.11;
  EXPECT_THAT(WarningsOf(report), ElementsAre(HasSubstr("130 km/h on the route, the ego at most 36; give "
                                                        "--set task.max_speed_mps=37")));
}

TEST(ScenarioWarnings, NameLanesThatAreLongerInSumoThanDrawn) {
  ScenarioReport report = GoodReport();
  report.survey.stretched = {"b_0", "elsewhere_0"};
  EXPECT_THAT(WarningsOf(report), ElementsAre(HasSubstr("SUMO's length of b_0 is not the one drawn")));
}

TEST(ScenarioWarnings, NameTrafficThatIsNotThere) {
  ScenarioReport report = GoodReport();
  report.flows[0].entered = 3;
  EXPECT_THAT(WarningsOf(report), ElementsAre(HasSubstr("5 of 8 vehicles found no room")));
  report.flows[0] = {.edges = {"c"}, .vehicles = 8, .entered = 8, .meets_route = false};
  EXPECT_THAT(WarningsOf(report), ElementsAre(HasSubstr("no flow comes within 15 m of the ego's route")));
  report.flows.clear();
  EXPECT_THAT(WarningsOf(report), ElementsAre(HasSubstr("no traffic")));
  report.others = 2;
  EXPECT_THAT(WarningsOf(report), IsEmpty());
}

}  // namespace
}  // namespace dadrl
