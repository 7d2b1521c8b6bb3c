#include "actor/sim/sumo_pose.h"

#include <libsumo/libsumo.h>

#include <numbers>

namespace dadrl {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
// moveToXY looks for lanes at most this far away; beyond it the vehicle is off the road, at the same place.
constexpr double kMatchThreshold = 5.0;
constexpr int kKeepExactPosition = 2;

}  // namespace

Pose PoseFromSumo(const std::string& vehicle, double length_m) {
  const libsumo::TraCIPosition front = libsumo::Vehicle::getPosition(vehicle);
  const double heading = WrapAngle((90.0 - libsumo::Vehicle::getAngle(vehicle)) / kDegrees);
  return {Point{front.x, front.y} - length_m / 2.0 * Forward(heading), heading};
}

double ElevationFromSumo(const std::string& vehicle) { return libsumo::Vehicle::getPosition3D(vehicle).z; }

void MoveInSumo(const std::string& vehicle, const Pose& pose, double speed_mps, const std::string& edge,
                int lane_index) {
  const Point front = pose.position + kVehicleLength / 2.0 * Forward(pose.heading);
  const double north_based = 90.0 - WrapAngle(pose.heading) * kDegrees;
  libsumo::Vehicle::setSpeed(vehicle, speed_mps);
  libsumo::Vehicle::moveToXY(vehicle, edge, lane_index, front.x, front.y,
                             north_based < 0.0 ? north_based + 360.0 : north_based, kKeepExactPosition,
                             kMatchThreshold);
}

}  // namespace dadrl
