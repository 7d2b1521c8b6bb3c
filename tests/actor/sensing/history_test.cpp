#include "actor/sensing/history.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/step/driving_shape.h"
#include "tests/actor/test_maps.h"

namespace dadrl {
namespace {

class HistoryTest : public testing::Test {
 protected:
  void Push(const WorldState& world) { history_.Push(world, localizer_.Locate(world.ego.pose)); }
  void ReadVehicles() { history_.WriteVehicles(vehicles_); }
  void ReadEgo() { history_.WriteEgo(route_.goal(), ego_); }
  // Feature `f` of vehicle `slot` at row (0 oldest ... 4 now).
  float V(int slot, int row, int f) const { return vehicles_[static_cast<size_t>((slot * 5 + row) * 7 + f)]; }
  float E(int row, int f) const { return ego_[static_cast<size_t>(row * 20 + f)]; }
  bool Absent(int slot, int row) const {
    for (int f = 1; f < 7; ++f) EXPECT_TRUE(V(slot, row, 0) == 0.0f || V(slot, row, f) == 0.0f);
    return V(slot, row, 0) == 1.0f;
  }

  ObservationConfig config_;
  RoadMap map_ = test::StraightRoad();
  Route route_ = test::StraightRoute(map_);
  Localizer localizer_{map_, route_};
  History history_{config_};
  std::vector<float> vehicles_ = std::vector<float>(6 * 5 * 7, 9.0f);
  std::vector<float> ego_ = std::vector<float>(5 * 20, 9.0f);
};

TEST_F(HistoryTest, EmptyRoadIsAllAbsent) {
  Push(test::WorldWithEgo(20, 0));
  ReadVehicles();
  for (int slot = 0; slot < 6; ++slot) {
    for (int row = 0; row < 5; ++row) EXPECT_TRUE(Absent(slot, row));
  }
}

TEST_F(HistoryTest, RowsAreHalfSecondsApartAndInTheFrameOfNow) {
  // Ego drives 1 m a step east and then faces north; a car goes west at 0.5 m a step in the back lane.
  for (int step = 0; step <= 20; ++step) {
    WorldState world = test::WorldWithEgo(20 + step, 0, step == 20 ? std::numbers::pi / 2 : 0.0, 10.0);
    world.vehicles = {test::Vehicle(3, 60 - 0.5 * step, 6.4, std::numbers::pi, 5.0, 1)};
    Push(world);
  }
  ReadVehicles();
  ReadEgo();
  for (int row = 0; row < 5; ++row) {
    const double step = 5.0 * row;
    // Ego now at (40, 0) facing north: ahead is +y, left is -x.
    EXPECT_NEAR(V(0, row, 1), 6.4 / 30, 1e-6);
    EXPECT_NEAR(V(0, row, 2), (40 - (60 - 0.5 * step)) / 30, 1e-6);
    EXPECT_NEAR(V(0, row, 3), 0.0, 1e-6);  // west is a quarter turn left of north
    EXPECT_NEAR(V(0, row, 4), 1.0, 1e-6);
    EXPECT_NEAR(V(0, row, 5), 0.5, 1e-6);
    EXPECT_EQ(V(0, row, 6), 1.0f);
    EXPECT_EQ(V(0, row, 0), 0.0f);
    EXPECT_NEAR(E(row, 1), 0.0, 1e-6);
    EXPECT_NEAR(E(row, 2), (40 - (20 + step)) / 30, 1e-6);
    EXPECT_NEAR(E(row, 4), row == 4 ? 0.0 : -1.0, 1e-6);
    EXPECT_NEAR(E(row, 5), 1.0, 1e-6);
  }
  EXPECT_TRUE(Absent(1, 4));
}

TEST_F(HistoryTest, EgoRowCarriesAllTwentyFeaturesScaled) {
  WorldState world = test::WorldWithEgo(60, 3.2, 0.0, 8.0);
  world.ego.steering_rad = 0.361;
  world.ego.yaw_rate = -0.5;
  world.ego.velocity_lon = 7.0;
  world.ego.velocity_lat = 1.0;
  world.ego.acceleration_lon = -7.4;
  world.ego.acceleration_lat = 2.0;
  world.ego.jerk_lon = 10.0;
  world.ego.jerk_lat = -1e9;
  world.ego.angular_acceleration = 2.5;
  Push(world);
  ReadEgo();
  const std::vector<float> expected = {0,    0,      0,    1,    0,  0.8f, 1,    0.5f, -0.5f,   0.7f,
                                       0.5f, -1.48f, 0.4f, 0.5f, -5, 0.5f, 1.0f, 1.0f, -0.064f, 0.5f};
  for (int f = 0; f < 20; ++f) EXPECT_NEAR(E(4, f), expected[static_cast<size_t>(f)], 1e-6) << f;
  for (int row = 0; row < 4; ++row) {
    EXPECT_EQ(E(row, 0), 1.0f);
    for (int f = 1; f < 20; ++f) EXPECT_EQ(E(row, f), 0.0f);
  }
}

TEST_F(HistoryTest, KeepsTheNearestWithinTheRadiusInOrder) {
  WorldState world = test::WorldWithEgo(100, 0);
  for (int i = 0; i < 8; ++i) world.vehicles.push_back(test::Vehicle(i, 100 + 29.0 - 3 * i, 0, 0, i, 0));
  world.vehicles.push_back(test::Vehicle(20, 69.9, 0));  // 30.1 m away
  Push(world);
  ReadVehicles();
  for (int slot = 0; slot < 6; ++slot) EXPECT_NEAR(V(slot, 4, 1), (8.0 + 3 * slot) / 30, 1e-6);
}

TEST_F(HistoryTest, EqualDistancesAreOrderedById) {
  for (const bool swapped : {false, true}) {
    WorldState world = test::WorldWithEgo(100, 0);
    world.vehicles = {test::Vehicle(4, 110, 0, 0, 4), test::Vehicle(2, 90, 0, 0, 2)};
    if (swapped) std::swap(world.vehicles[0], world.vehicles[1]);
    Push(world);
    ReadVehicles();
    EXPECT_NEAR(V(0, 4, 5), 0.2, 1e-6);
  }
}

TEST_F(HistoryTest, AVehicleThatLoopedLosesItsOlderRows) {
  for (int step = 0; step <= 20; ++step) {
    WorldState world = test::WorldWithEgo(100, 0);
    // Until step 12 at x = 125, then it starts anew, near where it left.
    world.vehicles = {test::Vehicle(1, step < 13 ? 125.0 : 120.0, 0, 0, 5)};
    world.vehicles.front().trip = step < 13 ? 1 : 2;
    Push(world);
  }
  ReadVehicles();
  EXPECT_TRUE(Absent(0, 0) && Absent(0, 1) && Absent(0, 2));
  EXPECT_FALSE(Absent(0, 3) || Absent(0, 4));
}

TEST_F(HistoryTest, AVehicleThatWasAwayHasNoRowsBeforeThat) {
  for (int step = 0; step <= 20; ++step) {
    WorldState world = test::WorldWithEgo(100, 0);
    if (step != 10) world.vehicles = {test::Vehicle(1, 110, 0)};
    Push(world);
  }
  ReadVehicles();
  EXPECT_TRUE(Absent(0, 0) && Absent(0, 1) && Absent(0, 2));
  EXPECT_FALSE(Absent(0, 3));
}

TEST_F(HistoryTest, HoweverFastAVehicleIsItKeepsItsRows) {
  for (int step = 0; step <= 20; ++step) {
    WorldState world = test::WorldWithEgo(100, 0);
    world.vehicles = {test::Vehicle(1, 20 + 4.0 * step, 0, 0.0, 40.0)};
    Push(world);
  }
  ReadVehicles();
  for (int row = 0; row < 5; ++row) EXPECT_FALSE(Absent(0, row));
}

TEST_F(HistoryTest, ClearForgetsThePast) {
  for (int step = 0; step < 40; ++step) Push(test::WorldWithEgo(50, 0));
  history_.Clear();
  Push(test::WorldWithEgo(20, 0));
  ReadEgo();
  EXPECT_EQ(E(3, 0), 1.0f);
  EXPECT_EQ(E(4, 0), 0.0f);
}

TEST_F(HistoryTest, TurningTheWorldChangesNothing) {
  const auto record = [&](double angle, Point shift) {
    const RoadMap map = test::StraightRoad(angle, shift);
    const Route route = test::StraightRoute(map, angle, shift);
    Localizer localizer(map, route);
    History history(config_);
    for (int step = 0; step <= 25; ++step) {
      WorldState world = test::WorldWithEgo(0, 0, angle + 0.01 * step, 6.0);
      world.ego.pose.position = test::Moved({30 + 0.6 * step, 0.05 * step}, angle, shift);
      const Point other = test::Moved({60 - 0.7 * step, 6.4}, angle, shift);
      world.vehicles = {test::Vehicle(1, other.x, other.y, angle + std::numbers::pi, 7.0, 1)};
      history.Push(world, localizer.Locate(world.ego.pose));
    }
    std::vector<float> all(6 * 5 * 7 + 5 * 20);
    history.WriteVehicles(std::span(all).first(6 * 5 * 7));
    history.WriteEgo(route.goal(), std::span(all).last(5 * 20));
    return all;
  };
  const std::vector<float> reference = record(0.0, {});
  const std::vector<float> turned = record(2.1, {500.0, -300.0});
  for (size_t i = 0; i < reference.size(); ++i) EXPECT_NEAR(reference[i], turned[i], 1e-5) << i;
  EXPECT_TRUE(std::ranges::all_of(reference, [](float x) { return std::abs(x) <= 5.0f; }));
}

}  // namespace
}  // namespace dadrl
