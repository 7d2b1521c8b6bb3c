#include "actor/sim/traffic.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dadrl {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(DriverTypes, StayInTheirRangesAndFillThem) {
  Random random(1);
  const auto types = SampleDriverTypes(20000, random);
  double slowest = 9, fastest = 0, mean_gap = 0, mean_imperfection = 0;
  for (const DriverType& type : types) {
    slowest = std::min(slowest, type.speed_factor);
    fastest = std::max(fastest, type.speed_factor);
    mean_gap += type.min_gap_m / 20000;
    mean_imperfection += type.imperfection / 20000;
    EXPECT_GE(type.min_gap_m, 0.0);
    EXPECT_TRUE(type.imperfection >= 0 && type.imperfection <= 1);
    EXPECT_TRUE(type.lane_change_speed_gain >= 1 && type.lane_change_speed_gain < 2);
  }
  EXPECT_NEAR(slowest, 0.6, 0.001);
  EXPECT_NEAR(fastest, 1.0, 0.001);
  EXPECT_NEAR(mean_gap, 3.0, 0.02);
  EXPECT_NEAR(mean_imperfection, 0.5, 0.005);
}

TEST(DriverTypes, FollowTheSeed) {
  Random a(5), b(5), c(6);
  EXPECT_EQ(SampleDriverTypes(4, a)[3].impatience, SampleDriverTypes(4, b)[3].impatience);
  EXPECT_NE(SampleDriverTypes(4, a)[3].impatience, SampleDriverTypes(4, c)[3].impatience);
}

TEST(TrafficIds, ReadBack) {
  EXPECT_EQ(SocialIndex(SocialId(12)), 12);
  for (const char* id : {"ego", "v", "vx", "v1x", "", "12"}) EXPECT_EQ(SocialIndex(id), -1) << id;
}

TEST(TrafficXml, ProfileReplacesAnAttribute) {
  Scenario scenario;
  scenario.driver_types = 1;
  scenario.flows = {{.edges = {"a", "b"}, .arrival_lane = 1, .depart = FlowPosition::kLaneEnd}};
  const ProfileSettings profile{{}, {{"decel", "3"}, {"emergencyDecel", "5.0"}}};
  const std::string xml = TrafficXml(scenario, profile, {DriverType()}, {37.05}, {{"a"}, false, 10, 0});
  EXPECT_THAT(xml, HasSubstr(R"(decel="3")"));
  EXPECT_THAT(xml, Not(HasSubstr(R"(decel="4.5")")));
  EXPECT_THAT(xml, HasSubstr(R"(emergencyDecel="5.0")"));
  EXPECT_THAT(xml, HasSubstr(R"(departPos="37.05")"));
  EXPECT_THAT(xml, HasSubstr(R"(<route id="ego" edges="a"/>)"));
}

}  // namespace
}  // namespace dadrl
