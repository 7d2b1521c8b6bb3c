#include "actor/ego/ego_controller.h"

#include <gtest/gtest.h>

#include <cmath>

#include "actor/ego/ego_vehicle.h"
#include "tests/actor/ego/road_fixture.h"

namespace dadrl {
namespace {

// Drives one ego over a road.
class Drive {
 public:
  Drive(const RoadMap& map, const std::vector<std::string>& lanes, double speed)
      : route_(map, ConnectLanes(map, lanes).value(), Start(map, lanes), End(map, lanes)),
        controller_(map, route_) {
    vehicle_.Reset({route_.centre().At(0.0), route_.centre().HeadingAt(0.0)}, speed);
  }

  void Step(double target_speed, int lane_command) {
    const EgoCommand command = controller_.Control(vehicle_.state(), target_speed, lane_command);
    vehicle_.Step(command.target_speed_mps, command.target_steering_rad);
  }
  const EgoState& ego() const { return vehicle_.state(); }
  const EgoController& controller() const { return controller_; }
  const Route& route() const { return route_; }

 private:
  static Point Start(const RoadMap& map, const std::vector<std::string>& lanes) {
    return map.lanes()[static_cast<size_t>(map.FindLane(lanes.front()))].centre.points().front();
  }
  static Point End(const RoadMap& map, const std::vector<std::string>& lanes) {
    return map.lanes()[static_cast<size_t>(map.FindLane(lanes.back()))].centre.points().back();
  }

  Route route_;
  EgoController controller_;
  EgoVehicle vehicle_;
};

struct LaneChange {
  double speed;
  double half_s;
  double most_s;
};

class LaneChangeAt : public testing::TestWithParam<LaneChange> {};

TEST_P(LaneChangeAt, TakesAsLongAsThePapers) {
  const RoadMap map = StraightRoad();
  for (const int side : {1, -1}) {
    Drive drive(map, {side > 0 ? "a_0" : "a_1"}, GetParam().speed);
    const double start = side > 0 ? 0.0 : 3.2;
    double half = 0.0, most = 0.0, furthest = 0.0, before = 0.0;
    for (int step = 1; step < 120; ++step) {
      drive.Step(GetParam().speed, side);
      const double now = side * (drive.ego().pose.position.y - start);
      const auto crossed = [&](double place) { return 0.1 * (step - 1 + (place - before) / (now - before)); };
      if (half == 0.0 && now >= 1.6) half = crossed(1.6);
      if (most == 0.0 && now >= 2.88) most = crossed(2.88);
      furthest = std::max(furthest, now);
      before = now;
    }
    EXPECT_NEAR(half, GetParam().half_s, 0.1 * GetParam().half_s);
    EXPECT_NEAR(most, GetParam().most_s, 0.1 * GetParam().most_s);
    EXPECT_LT(furthest, 3.3);
    EXPECT_NEAR(before, 3.2, 0.02);
  }
}

INSTANTIATE_TEST_SUITE_P(Speeds, LaneChangeAt,
                         testing::Values(LaneChange{3, 3.1, 5.0}, LaneChange{5, 1.9, 3.4},
                                         LaneChange{8, 1.3, 2.4}, LaneChange{10, 1.0, 2.0}),
                         [](const auto& test) { return fmt::format("{}mps", test.param.speed); });

TEST(EgoController, LaneChangeLetGoBeforeItsMiddleReturns) {
  const RoadMap map = StraightRoad();
  Drive drive(map, {"a_0"}, 8.0);
  while (drive.ego().pose.position.y < 1.0) drive.Step(8.0, 1);
  for (int step = 0; step < 60; ++step) drive.Step(8.0, 0);
  EXPECT_NEAR(drive.ego().pose.position.y, 0.0, 0.02);
}

TEST(EgoController, LaneChangeLetGoBehindItsMiddleIsCompleted) {
  const RoadMap map = StraightRoad();
  Drive drive(map, {"a_0"}, 8.0);
  while (drive.ego().pose.position.y < 2.1) drive.Step(8.0, 1);
  double furthest = 0.0;
  for (int step = 0; step < 60; ++step) {
    drive.Step(8.0, 0);
    furthest = std::max(furthest, drive.ego().pose.position.y);
  }
  EXPECT_NEAR(drive.ego().pose.position.y, 3.2, 0.02);
  EXPECT_LT(furthest, 3.35);
}

TEST(EgoController, CommandWithoutALaneThereKeepsTheLane) {
  const RoadMap map = StraightRoad();
  Drive drive(map, {"a_0"}, 8.0);
  for (int step = 0; step < 50; ++step) drive.Step(8.0, -1);
  EXPECT_NEAR(drive.ego().pose.position.y, 0.0, 1e-6);
}

TEST(EgoController, StraightDriveIsFreeOfJerk) {
  const RoadMap map = StraightRoad();
  Drive drive(map, {"a_0"}, 10.0);
  for (int step = 0; step < 600; ++step) {
    drive.Step(10.0, 0);
    EXPECT_LT(std::hypot(drive.ego().jerk_lon, drive.ego().jerk_lat), 0.01);
  }
}

TEST(EgoController, CopiesPredictWithoutDisturbing) {
  const RoadMap map = StraightRoad();
  Drive drive(map, {"a_0"}, 8.0);
  EgoController other = drive.controller();
  EXPECT_EQ(&other.paths(), &drive.controller().paths());
  other.Control(drive.ego(), 8.0, 1);
  EXPECT_NE(&other.followed_path(), &other.current_path());
  EXPECT_EQ(&drive.controller().followed_path(), &drive.controller().current_path());
}

// A lane that forks into two that run apart slowly, as at the mouth of a turn.
RoadMap Fork() {
  return RoadMap({MakeLane("a_0", 0, {{0, 0}, {60, 0}}, {1, 2}), MakeLane(":J_0", 0, {{60, 0}, {80, 0}}, {3}),
                  MakeLane(":J_1", 1, {{60, 0}, {70, 0.8}, {80, 3.2}}, {4}),
                  MakeLane("b_0", 0, {{80, 0}, {200, 0}}), MakeLane("b_1", 1, {{80, 3.2}, {200, 3.2}})},
                 {});
}

TEST(EgoController, CornerCuttingDoesNotChangeTheBranch) {
  const RoadMap map = Fork();
  for (const char* goal : {"b_0", "b_1"}) {
    Drive drive(map, {"a_0", goal}, 8.0);
    for (int step = 0; step < 180; ++step) drive.Step(8.0, 0);
    EXPECT_NEAR(drive.ego().pose.position.y, goal[2] == '0' ? 0.0 : 3.2, 0.05);
  }
}

TEST(EgoController, CommandBeforeAForkChoosesTheBranch) {
  const RoadMap map = Fork();
  Drive left(map, {"a_0", "b_0"}, 8.0);
  for (int step = 0; step < 180; ++step) left.Step(8.0, left.ego().pose.position.x < 85.0 ? 1 : 0);
  EXPECT_NEAR(left.ego().pose.position.y, 3.2, 0.05);
  Drive right(map, {"a_0", "b_1"}, 8.0);
  for (int step = 0; step < 180; ++step) right.Step(8.0, right.ego().pose.position.x < 85.0 ? -1 : 0);
  EXPECT_NEAR(right.ego().pose.position.y, 0.0, 0.05);
}

// A quarter turn of the given radius to the left, after 60 m.
RoadMap Bend(double radius) {
  std::vector<Point> points{{0, 0}};
  for (int i = 0; i <= 30; ++i) {
    const double angle = i * std::numbers::pi / 60;
    points.push_back({60 + radius * std::sin(angle), radius - radius * std::cos(angle)});
  }
  points.push_back(points.back() + Point{0, 60});
  return RoadMap({MakeLane("a_0", 0, points)}, {});
}

TEST(EgoController, IsSlowEnoughWhenTheCurveBegins) {
  for (const auto& [radius, cap] : {std::pair{6.0, 5.56}, std::pair{12.0, 6.94}}) {
    for (const double speed : {10.0, 15.0}) {
      Drive drive(Bend(radius), {"a_0"}, speed);
      double fastest = 0.0;
      while (drive.ego().pose.heading < 1.4) {
        drive.Step(speed, 0);
        if (drive.ego().pose.position.x > 60.0) fastest = std::max(fastest, drive.ego().speed_mps);
      }
      EXPECT_LT(fastest, cap + 0.6) << radius << " " << speed;
      EXPECT_GT(fastest, cap - 0.6) << radius << " " << speed;
      for (int step = 0; step < 40; ++step) drive.Step(speed, 0);
      EXPECT_GT(drive.ego().speed_mps, 0.95 * speed);
    }
  }
}

TEST(EgoController, WideCurvesAreNotSlowedDown) {
  Drive drive(Bend(48.9), {"a_0"}, 10.0);
  double furthest = 0.0;
  for (int step = 0; step < 150; ++step) {
    drive.Step(10.0, 0);
    furthest = std::max(furthest,
                        drive.controller().current_path().centre.Project(drive.ego().pose.position).distance);
    EXPECT_GT(drive.ego().speed_mps, 9.99);
  }
  EXPECT_LT(furthest, 0.3);
}

// A lane around a ring, drawn as coarsely as the roundabouts are.
TEST(EgoController, PolygonsOfTheRoadDoNotShakeTheEgo) {
  std::vector<Point> points;
  for (int i = 0; i <= 35; ++i) {
    points.push_back({48.9 * std::cos(i * 0.1496), 48.9 * std::sin(i * 0.1496)});
  }
  const RoadMap map({MakeLane("a_0", 0, points)}, {});
  Drive drive(map, {"a_0"}, 10.0);
  for (int step = 0; step < 200; ++step) {
    drive.Step(10.0, 0);
    if (step >= 20) {
      EXPECT_LT(std::hypot(drive.ego().jerk_lon, drive.ego().jerk_lat), 1.0) << step;
    }
  }
  EXPECT_NEAR(drive.ego().acceleration_lat, 100.0 / 48.9, 0.15);
}

}  // namespace
}  // namespace dadrl
