// The traffic scene at one simulation step, as everything above the simulator sees it.
#pragma once

#include <vector>

#include "actor/sim/geometry.h"

namespace dadrl {

// Every vehicle of the task is this box, the ego included (paper: 3.68 m x 1.47 m).
constexpr double kVehicleLength = 3.68;
constexpr double kVehicleWidth = 1.47;
constexpr double kStepSeconds = 0.1;

struct SocialVehicle {
  int id = 0;  // of the population; stays the same when the vehicle loops
  Pose pose;   // of the box's centre
  double speed_mps = 0.0;
  int lane_index = 0;  // 0 is the rightmost of its road
};

// The ego in its own frame: longitudinal ahead, lateral to the left.
struct EgoState {
  Pose pose;  // of the box's centre
  double speed_mps = 0.0;
  double steering_rad = 0.0;  // front wheel, left positive
  double yaw_rate = 0.0;      // rad/s
  double velocity_lon = 0.0;
  double velocity_lat = 0.0;
  double acceleration_lon = 0.0;  // m/s^2, over the last step
  double acceleration_lat = 0.0;
  double jerk_lon = 0.0;  // m/s^3
  double jerk_lat = 0.0;
  double angular_acceleration = 0.0;  // rad/s^2
};

struct WorldState {
  int step = 0;  // simulation steps since the ego was spawned
  EgoState ego;
  std::vector<SocialVehicle> vehicles;  // in the network, any order
};

}  // namespace dadrl
