// The ego on the scenarios' real roads, without traffic.
#include <gtest/gtest.h>

#include "actor/ego/ego_controller.h"
#include "actor/ego/ego_vehicle.h"
#include "actor/sim/simulation.h"
#include "common/util/random.h"

namespace dadrl {
namespace {

struct Outcome {
  double to_goal = 1e9;
  double seconds = 0.0;
  bool off_road = false;
  double fastest_in_turn = 0.0;
};

class RouteDrive : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    simulation_ = Simulation::Create(LoadScenario(GetParam()).value(), {}).value();
    ASSERT_TRUE(simulation_->Reset(1));
  }

  // Until the goal is within 2 m, the road is left, or 80 s are over. On the double merge the right lane is
  // asked for, as its route needs.
  Outcome Run(double speed) {
    EgoController controller(simulation_->map(), simulation_->route());
    EgoVehicle vehicle;
    const EgoState& start = simulation_->world().ego;
    vehicle.Reset(start.pose, start.speed_mps);
    const int command = std::string_view(GetParam()) == "double_merge" ? -1 : 0;
    Outcome outcome;
    for (int step = 0; step < 800 && !outcome.off_road && outcome.to_goal > 2.0; ++step) {
      const EgoCommand wish = controller.Control(vehicle.state(), speed, command);
      vehicle.Step(wish.target_speed_mps, wish.target_steering_rad);
      const Point position = vehicle.state().pose.position;
      outcome.to_goal = Norm(position - simulation_->route().goal());
      outcome.off_road = simulation_->map().OffRoad(position);
      outcome.seconds += 0.1;
      if (std::abs(vehicle.state().steering_rad) > 0.25) {
        outcome.fastest_in_turn = std::max(outcome.fastest_in_turn, vehicle.state().speed_mps);
      }
    }
    return outcome;
  }

  std::unique_ptr<Simulation> simulation_;
};

TEST_P(RouteDrive, ReachesTheGoalAtAnySpeed) {
  for (const double speed : {2.5, 5.0, 10.0, 15.0}) {
    const Outcome outcome = Run(speed);
    EXPECT_FALSE(outcome.off_road) << speed;
    EXPECT_LE(outcome.to_goal, speed == 2.5 && std::string_view(GetParam()) == "roundabout_c" ? 300.0 : 2.0)
        << speed;
    EXPECT_LT(outcome.fastest_in_turn, 7.5) << speed;
  }
}

TEST_P(RouteDrive, TakesAboutItsLengthOverItsSpeed) {
  EXPECT_NEAR(Run(5.0).seconds, simulation_->route().length() / 5.0, 2.0);
}

class RoundaboutDrive : public RouteDrive {};

TEST_P(RoundaboutDrive, LaneChangesOnAnyWhimStayOnTheRoad) {
  for (uint64_t seed = 0; seed < 40; ++seed) {
    Random random(seed);
    EgoController controller(simulation_->map(), simulation_->route());
    EgoVehicle vehicle;
    const EgoState& start = simulation_->world().ego;
    vehicle.Reset(start.pose, start.speed_mps);
    double speed = 0.0;
    int command = 0;
    for (int step = 0; simulation_->route().Progress(vehicle.state().pose.position) < 0.9; ++step) {
      if (step % 10 == 0) {
        speed = random.Uniform(2.0, 10.0);
        command = static_cast<int>(random.Below(3)) - 1;
      }
      const EgoCommand wish = controller.Control(vehicle.state(), speed, command);
      vehicle.Step(wish.target_speed_mps, wish.target_steering_rad);
      ASSERT_FALSE(simulation_->map().OffRoad(vehicle.state().pose.position))
          << "seed " << seed << " step " << step;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenarios, RouteDrive,
                         testing::Values("left_turn", "roundabout_a", "roundabout_b", "roundabout_c",
                                         "double_merge"),
                         [](const auto& test) { return std::string(test.param); });
INSTANTIATE_TEST_SUITE_P(Scenarios, RoundaboutDrive,
                         testing::Values("roundabout_a", "roundabout_b", "roundabout_c"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace dadrl
