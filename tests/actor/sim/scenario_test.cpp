#include "actor/sim/scenario.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

namespace dadrl {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

const char* const kGood = R"(warm_up_s: 2
ego:
  lanes: [a_0, b_1]
  start_offset_m: 4.5
traffic:
  driver_types: 3
  flows:
    - {edges: [a, b], depart_lane: 1, arrival_lane: 2, depart: lane_end, arrival: random}
profiles:
  calibrated: {driver: {emergencyDecel: 5.0}, sumo: {lanechange.duration: 3}}
  plain: {}
)";

class ScenarioFile : public testing::Test {
 protected:
  ScenarioFile()
      : directory_(fs::path(testing::TempDir()) /
                   testing::UnitTest::GetInstance()->current_test_info()->name()) {
    fs::create_directories(directory_ / "mine");
    std::ofstream(directory_ / "mine/network.net.xml") << "<net/>";
  }
  ~ScenarioFile() override { fs::remove_all(directory_); }

  Result<Scenario> Load(const std::string& yaml) {
    std::ofstream(directory_ / "mine/scenario.yaml") << yaml;
    return LoadScenario("mine", directory_);
  }
  // The error after one line of the good file was replaced.
  std::string ErrorWith(const std::string& from, const std::string& to) {
    std::string yaml = kGood;
    const size_t at = yaml.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    yaml.replace(at, from.size(), to);
    auto scenario = Load(yaml);
    EXPECT_FALSE(scenario) << to;
    return scenario ? "" : scenario.error().message;
  }

  const fs::path directory_;
};

TEST_F(ScenarioFile, IsReadWhole) {
  const auto scenario = Load(kGood);
  ASSERT_TRUE(scenario) << scenario.error().message;
  EXPECT_EQ(scenario->name, "mine");
  EXPECT_EQ(scenario->network, directory_ / "mine/network.net.xml");
  EXPECT_EQ(scenario->warm_up_s, 2.0);
  EXPECT_THAT(scenario->ego_lanes, ElementsAre("a_0", "b_1"));
  EXPECT_EQ(scenario->ego_start_offset_m, 4.5);
  EXPECT_EQ(scenario->population(), 3);
  EXPECT_THAT(scenario->flows[0].edges, ElementsAre("a", "b"));
  EXPECT_EQ(scenario->flows[0].depart_lane, 1);
  EXPECT_EQ(scenario->flows[0].arrival_lane, 2);
  EXPECT_EQ(scenario->flows[0].depart, FlowPosition::kLaneEnd);
  EXPECT_EQ(scenario->flows[0].arrival, FlowPosition::kRandom);
  EXPECT_THAT(scenario->profile(TrafficProfile::kCalibrated).driver_attributes,
              ElementsAre(testing::Pair("emergencyDecel", "5.0")));
  EXPECT_TRUE(scenario->profile(TrafficProfile::kPlain).sumo_options.empty());
}

TEST_F(ScenarioFile, FaultsAreNamedWithFileLineAndKey) {
  EXPECT_THAT(ErrorWith("warm_up_s: 2", "warm_up: 2"),
              AllOf(HasSubstr("mine/scenario.yaml:1: unknown key 'warm_up'"), HasSubstr("'warm_up_s'")));
  EXPECT_THAT(ErrorWith("  start_offset_m: 4.5\n", ""), HasSubstr("'ego.start_offset_m' is missing"));
  EXPECT_THAT(ErrorWith("4.5", "far"),
              HasSubstr("scenario.yaml:4: 'ego.start_offset_m': 'far' is not a number between 0"));
  EXPECT_THAT(ErrorWith("4.5", "nan"), HasSubstr("'ego.start_offset_m'"));
  EXPECT_THAT(ErrorWith("driver_types: 3", "driver_types: 0"), HasSubstr("'traffic.driver_types'"));
  EXPECT_THAT(ErrorWith("driver_types: 3", "driver_types: 1.5"), HasSubstr("not a whole number"));
  EXPECT_THAT(ErrorWith("lanes: [a_0, b_1]", "lanes: []"), HasSubstr("'ego.lanes' must be a list of names"));
  EXPECT_THAT(ErrorWith("depart: lane_end", "depart: anywhere"),
              HasSubstr("'traffic.flows[0].depart' is not one of: random, lane_end"));
  EXPECT_THAT(ErrorWith("depart: lane_end", "departs: random"),
              HasSubstr("nearest is 'traffic.flows[0].depart'"));
  EXPECT_THAT(ErrorWith("  plain: {}\n", ""), HasSubstr("'profiles.plain' is missing"));
  EXPECT_THAT(ErrorWith("plain: {}", "plain: {sumo: fast}"), HasSubstr("'profiles.plain.sumo' must hold"));
  EXPECT_THAT(ErrorWith("plain: {}", "plain: {sumo: {a: [1]}}"),
              HasSubstr("'profiles.plain.sumo' must hold"));
  EXPECT_THAT(ErrorWith("traffic:", "traffic: ]"), HasSubstr("mine/scenario.yaml"));
  EXPECT_THAT(ErrorWith("plain: {}", "plain: &p {driver: *p}"), HasSubstr("mine/scenario.yaml:11: anchors"));
  EXPECT_THAT(ErrorWith("plain: {}", "plain: {}\n  plain: {}"), HasSubstr("stands here a second time"));
}

TEST_F(ScenarioFile, OptionsWithWhichSumoWritesFilesAreRefused) {
  for (const char* name :
       {"tripinfo-output", "netstate-dump", "log", "save-state.files", "device.ssm.file"}) {
    EXPECT_THAT(ErrorWith("plain: {}", fmt::format("plain: {{sumo: {{{}: /tmp/mine}}}}", name)),
                AllOf(HasSubstr(name), HasSubstr("would write the same file")));
  }
}

TEST_F(ScenarioFile, BrakingThatAbortsSumoIsRefused) {
  EXPECT_THAT(ErrorWith("emergencyDecel: 5.0", "emergencyDecel: 4.5"),
              AllOf(HasSubstr("mine/scenario.yaml:10: 'profiles.calibrated.driver.emergencyDecel' is 4.5"),
                    HasSubstr("'profiles.calibrated.driver.decel' is 4.5"), HasSubstr("more than 4.5")));
  EXPECT_THAT(ErrorWith("emergencyDecel: 5.0", "decel: 9"), HasSubstr("driver.emergencyDecel' is 9"));
  EXPECT_THAT(ErrorWith("emergencyDecel: 5.0", "decel: 6.0, emergencyDecel: 5.0"), HasSubstr("more than 6"));
  EXPECT_THAT(ErrorWith("emergencyDecel: 5.0", "emergencyDecel: hard"), HasSubstr("is not a number above 0"));
  EXPECT_THAT(ErrorWith("plain: {}", "plain: {sumo: {default.emergencydecel: decel}}"),
              HasSubstr("'profiles.plain.sumo.default.emergencydecel' is not for scenarios; set "
                        "'profiles.plain.driver.emergencyDecel'"));
}

TEST_F(ScenarioFile, MissingOrEmptyFilesAreErrorsNotCrashes) {
  EXPECT_EQ(Load("").error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(Load("just words").error().code, ErrorCode::kInvalidArgument);
  fs::remove(directory_ / "mine/network.net.xml");
  EXPECT_EQ(Load(kGood).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(LoadScenario("mine", directory_ / "nowhere").error().code, ErrorCode::kNotFound);
}

TEST_F(ScenarioFile, MayDriveOnAnothersNetwork) {
  fs::create_directories(directory_ / "other");
  std::ofstream(directory_ / "other/network.net.xml") << "<net/>";
  const auto scenario = Load(std::string("network: other\n") + kGood);
  ASSERT_TRUE(scenario);
  EXPECT_EQ(scenario->network, directory_ / "other/network.net.xml");
  for (const char* out : {"../../etc", ".", "..", "/etc", "[a]", "''"}) {
    EXPECT_THAT(Load(fmt::format("network: {}\n{}", out, kGood)).error().message,
                HasSubstr("is not the name of another scenario"))
        << out;
  }
}

TEST(Scenarios, TheFiveArePresentAndLoad) {
  EXPECT_THAT(ScenarioNames(),
              ElementsAre("double_merge", "left_turn", "roundabout_a", "roundabout_b", "roundabout_c"));
  for (const std::string& name : ScenarioNames()) EXPECT_TRUE(LoadScenario(name)) << name;
}

TEST(Scenarios, UnknownNameSuggestsTheNearest) {
  const auto scenario = LoadScenario("left_trun");
  ASSERT_FALSE(scenario);
  EXPECT_EQ(scenario.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(scenario.error().message, HasSubstr("the nearest is 'left_turn'"));
  EXPECT_FALSE(LoadScenario("../left_turn"));
}

TEST(Scenarios, EnvironmentVariableMovesTheDirectory) {
  const fs::path before = ScenarioDirectory();
  setenv("DADRL_SCENARIOS", "/some/where", 1);
  EXPECT_EQ(ScenarioDirectory(), "/some/where");
  unsetenv("DADRL_SCENARIOS");
  EXPECT_EQ(ScenarioDirectory(), before);
}

}  // namespace
}  // namespace dadrl
