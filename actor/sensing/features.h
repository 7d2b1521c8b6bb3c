// What each number of an observation means and how it is scaled: the one table of the project.
//
//  vehicles [6, 5, 7] and the first seven of ego [5, 20]
//   0 absent    1 when the row does not exist (then all others are 0)
//   1 x         ahead of the ego now           / 30 m
//   2 y         to the left of the ego now     / 30 m
//   3 cos       of the heading relative to the ego's heading now
//   4 sin
//   5 speed                                    / 10 m/s
//   6 lane      0 rightmost, 1 next, -1 unknown (as it is)
//  ego, from 7
//   7 steering  front wheel, left positive     / 0.722 rad (its stop)
//   8 yaw rate                                 / 1 rad/s
//   9 v_lon                                    / 10 m/s
//  10 v_lat                                    / 2 m/s
//  11 a_lon                                    / 5 m/s^2
//  12 a_lat                                    / 5 m/s^2
//  13 jerk_lon                                 / 20 m/s^3
//  14 jerk_lat                                 / 20 m/s^3
//  15 angular acceleration                     / 5 rad/s^2
//  16 speed limit of the lane, 0 off the lanes / 10 m/s
//  17 goal x    ahead of the ego now           / 50 m
//  18 goal y    to the left of the ego now     / 50 m
//  19 remaining fraction of the route, in [0, 1]
//
// Every value is clamped to DrivingShape::kFeatureBound: inside the range and the resolution of half
// floats.
#pragma once

#include <algorithm>

#include "common/step/driving_shape.h"

namespace dadrl::feature {

constexpr double kPosition = 30.0;
constexpr double kSpeed = 10.0;
constexpr double kSteering = 0.722;
constexpr double kYawRate = 1.0;
constexpr double kLateralSpeed = 2.0;
constexpr double kAcceleration = 5.0;
constexpr double kJerk = 20.0;
constexpr double kAngularAcceleration = 5.0;
constexpr double kGoal = 50.0;
constexpr double kBound = DrivingShape::kFeatureBound;

inline float Scaled(double value, double scale) {
  return static_cast<float>(std::clamp(value / scale, -kBound, kBound));
}

}  // namespace dadrl::feature
