// What a broken scenario, a failing simulator or a careless caller get.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <libsumo/libsumo.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "actor/sim/simulation.h"

namespace dadrl {
namespace {

using testing::HasSubstr;

Scenario LeftTurn() { return LoadScenario("left_turn").value(); }

Error ErrorOf(const Scenario& scenario) {
  const auto simulation = Simulation::Create(scenario, {});
  EXPECT_FALSE(simulation);
  return simulation ? Error{} : simulation.error();
}

TEST(SimulationFailure, MissingNetworkIsAnErrorAndTheProcessGoesOn) {
  Scenario scenario = LeftTurn();
  scenario.network = "/no/such/network.net.xml";
  EXPECT_THAT(ErrorOf(scenario).message, HasSubstr("/no/such/network.net.xml"));
  EXPECT_TRUE(Simulation::Create(LeftTurn(), {}));
}

TEST(SimulationFailure, BrokenNetworkIsAnError) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "broken.net.xml";
  std::ofstream(file) << "<net><edge id=";
  Scenario scenario = LeftTurn();
  scenario.network = file;
  EXPECT_EQ(ErrorOf(scenario).code, ErrorCode::kInvalidArgument);
  std::filesystem::remove(file);
}

TEST(SimulationFailure, WrongRouteNamesTheLane) {
  Scenario scenario = LeftTurn();
  scenario.ego_lanes = {"south-SN_1", "north_0"};
  EXPECT_EQ(ErrorOf(scenario).code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(ErrorOf(scenario).message, HasSubstr("lane 'north_0' is not in the network"));
  scenario = LeftTurn();
  scenario.ego_lanes = {"south-SN_0", "west-EW_0"};
  EXPECT_THAT(ErrorOf(scenario).message, HasSubstr("no connection leads from lane 'south-SN_0'"));
  scenario = LeftTurn();
  scenario.ego_start_offset_m = 60;
  EXPECT_THAT(ErrorOf(scenario).message, HasSubstr("exceeds lane 'south-SN_1'"));
}

TEST(SimulationFailure, WrongFlowNamesTheEdge) {
  Scenario scenario = LeftTurn();
  scenario.flows[0].edges[1] = "nowhere";
  EXPECT_THAT(ErrorOf(scenario).message, HasSubstr("edge 'nowhere' is not in the network"));
  scenario = LeftTurn();
  scenario.flows[0].depart_lane = 2;
  EXPECT_THAT(ErrorOf(scenario).message, HasSubstr("edge 'west-WE' has no lane 2"));
  scenario = LeftTurn();
  scenario.flows[0].edges = {"west-WE", "west-EW"};
  EXPECT_EQ(ErrorOf(scenario).code, ErrorCode::kInvalidArgument);
}

TEST(SimulationFailure, WrongProfileIsToldInSumosWords) {
  Scenario scenario = LeftTurn();
  scenario.calibrated.sumo_options = {{"lanechange.duratoin", "3"}};
  EXPECT_EQ(ErrorOf(scenario).code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(ErrorOf(scenario).message, HasSubstr("lanechange.duratoin"));
  scenario = LeftTurn();
  scenario.calibrated.driver_attributes = {{"decel", "strong"}};
  EXPECT_THAT(ErrorOf(scenario).message, HasSubstr("decel"));
}

TEST(SimulationFailure, OfSeveralOnlyTheOneResetLastRuns) {
  const auto first = Simulation::Create(LeftTurn(), {});
  ASSERT_TRUE((*first)->Reset(1));
  const auto second = Simulation::Create(LoadScenario("double_merge").value(), {});
  EXPECT_THAT((*first)->Step((*first)->world().ego).error().message, HasSubstr("one at a time"));
  ASSERT_TRUE((*second)->Reset(1));
  EXPECT_TRUE((*second)->Step((*second)->world().ego));
  EXPECT_FALSE((*first)->Step((*first)->world().ego));
  ASSERT_TRUE((*first)->Reset(1));
  EXPECT_TRUE((*first)->Step((*first)->world().ego));
}

TEST(SimulationFailure, StepBeforeResetIsRefused) {
  const auto simulation = Simulation::Create(LeftTurn(), {});
  EXPECT_FALSE((*simulation)->Step(EgoState()));
}

TEST(SimulationFailure, EgoThatIsNotFiniteIsRefusedAndNothingHappens) {
  const auto simulation = Simulation::Create(LeftTurn(), {});
  ASSERT_TRUE((*simulation)->Reset(1));
  EgoState ego = (*simulation)->world().ego;
  for (double* field : {&ego.pose.position.x, &ego.pose.position.y, &ego.pose.heading, &ego.speed_mps}) {
    const double before = *field;
    *field = std::nan("");
    EXPECT_EQ((*simulation)->Step(ego).error().code, ErrorCode::kInvalidArgument);
    *field = before;
  }
  EXPECT_EQ((*simulation)->world().step, 0);
  EXPECT_TRUE((*simulation)->Step(ego));
}

class Sabotage : public testing::TestWithParam<std::pair<const char*, void (*)()>> {};

// Behind the simulation's back, through the library it drives.
TEST_P(Sabotage, EndsTheEpisodeAndResetIsAsIfNothingHadHappened) {
  const auto simulation = Simulation::Create(LeftTurn(), {});
  const auto positions = [&](uint64_t seed) {
    EXPECT_TRUE((*simulation)->Reset(seed));
    const EgoState ego = (*simulation)->world().ego;
    std::vector<double> xs;
    for (int step = 0; step < 30; ++step) EXPECT_TRUE((*simulation)->Step(ego));
    for (const SocialVehicle& vehicle : (*simulation)->world().vehicles)
      xs.push_back(vehicle.pose.position.x);
    return xs;
  };
  const auto untouched = positions(9);
  ASSERT_TRUE((*simulation)->Reset(9));
  const EgoState ego = (*simulation)->world().ego;
  for (int step = 0; step < 5; ++step) ASSERT_TRUE((*simulation)->Step(ego));
  GetParam().second();
  const Status failed = (*simulation)->Step(ego);
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().code, ErrorCode::kInternal);
  EXPECT_FALSE((*simulation)->Step(ego)) << "the lost episode must not go on";
  EXPECT_EQ(positions(9), untouched);
}

INSTANTIATE_TEST_SUITE_P(
    Simulator, Sabotage,
    testing::Values(
        std::pair<const char*, void (*)()>{
            "VehicleVanishes", [] { libsumo::Vehicle::remove(libsumo::Vehicle::getIDList().at(3)); }},
        std::pair<const char*, void (*)()>{"EgoVanishes", [] { libsumo::Vehicle::remove("ego"); }},
        std::pair<const char*, void (*)()>{"SimulatorCloses", [] { libsumo::Simulation::close(); }}),
    [](const auto& test) { return std::string(test.param.first); });

}  // namespace
}  // namespace dadrl
