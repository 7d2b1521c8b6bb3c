// The traffic scene at one simulation step, as everything above the simulator sees it.
#pragma once

#include <vector>

#include "actor/sim/geometry.h"

namespace dadrl {

// The box of the ego, and of every vehicle that a scenario says nothing else about (paper: 3.68 m x 1.47 m).
constexpr double kVehicleLength = 3.68;
constexpr double kVehicleWidth = 1.47;
constexpr double kStepSeconds = 0.1;
// SUMO's class of the ego, and of what drives unless a scenario says otherwise.
constexpr const char* kCarClass = "passenger";

struct SocialVehicle {
  OrientedBox box() const { return {pose, length_m, width_m}; }

  int id = 0;  // stays the same when the vehicle loops; the scenario's population comes first
  Pose pose;   // of the box's centre
  double speed_mps = 0.0;
  int lane_index =
      0;  // as SUMO counts: 0 is the rightmost of its road (where one drives on the left, the leftmost)
  int trip = 0;  // how often it has entered the road before: between two trips it may be anywhere
  double length_m = kVehicleLength;
  double width_m = kVehicleWidth;
  double elevation_m = 0.0;  // of the road under it
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
  double elevation_m = 0.0;           // of the road under it
};

struct WorldState {
  int step = 0;  // simulation steps since the ego was spawned
  EgoState ego;
  std::vector<SocialVehicle> vehicles;  // in the network and on the ego's level, any order
};

}  // namespace dadrl
