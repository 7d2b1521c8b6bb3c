#include "actor/sim/sumo_pose.h"

#include <libsumo/libsumo.h>

#include <numbers>

#include "actor/sim/world_state.h"

namespace dadrl {
namespace {

constexpr double kHalfLength = kVehicleLength / 2.0;
constexpr double kDegrees = 180.0 / std::numbers::pi;
// moveToXY looks for lanes at most this far away; beyond it the vehicle is off the road, at the same place.
constexpr double kMatchThreshold = 5.0;
constexpr int kKeepExactPosition = 2;

}  // namespace

Pose PoseFromSumo(const std::string& vehicle) {
  const libsumo::TraCIPosition front = libsumo::Vehicle::getPosition(vehicle);
  const double heading = WrapAngle((90.0 - libsumo::Vehicle::getAngle(vehicle)) / kDegrees);
  return {Point{front.x, front.y} - kHalfLength * Forward(heading), heading};
}

void MoveInSumo(const std::string& vehicle, const Pose& pose, double speed_mps) {
  const Point front = pose.position + kHalfLength * Forward(pose.heading);
  const double north_based = 90.0 - WrapAngle(pose.heading) * kDegrees;
  libsumo::Vehicle::setSpeed(vehicle, speed_mps);
  libsumo::Vehicle::moveToXY(vehicle, "", 0, front.x, front.y,
                             north_based < 0.0 ? north_based + 360.0 : north_based, kKeepExactPosition,
                             kMatchThreshold);
}

}  // namespace dadrl
