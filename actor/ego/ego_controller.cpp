#include "actor/ego/ego_controller.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "actor/ego/ego_vehicle.h"

namespace dadrl {
namespace {

// Another path becomes the current one only when it is this much nearer: paths that part at a fork lie on top
// of each other at first, and cutting a corner must not change the branch.
constexpr double kHysteresis = 0.8;
// A path can be chosen from at most this far beside it, driving roughly its way.
constexpr double kReach = 4.8;
constexpr double kAlignment = std::numbers::pi / 3.0;
// A lane change begins this far beside the path and is over this near to it.
constexpr double kChangeBegins = 0.5;
constexpr double kChangeEnds = 0.15;
// The wheel's angle in a lane change on a straight (paper code: 5 degrees), and the curvature up to which a
// road is one, 1/m. A limit in a bend would carry the ego off the road.
constexpr double kChangeSteering = 5.0 * std::numbers::pi / 180.0;
constexpr double kStraight = 1e-3;
// Braking before a curve, m/s^2: nearly all there is, as the paper's controller does; and the lag with which
// the speed follows its target, s.
constexpr double kCurveBraking = 7.0;
constexpr double kSpeedLag = 0.25;

// Pursuit distances: lane keeping has the bandwidth of the paper's controller, lane changes its duration.
double KeepingDistance(double speed) { return 2.3 + 0.24 * speed; }
double ChangingDistance(double speed) { return 3.5 + 0.6 * speed; }

}  // namespace

EgoController::EgoController(const RoadMap& map, const Route& route)
    : paths_(std::make_shared<const std::vector<Path>>(FindPaths(map, route))),
      sides_(std::make_shared<PathSides>(*paths_)),
      initial_(PathOfRoute(*paths_, route)) {
  Reset();
}

void EgoController::Reset() {
  projections_.assign(paths_->size(), {});
  current_ = followed_ = initial_;
  changing_lane_ = false;
}

EgoCommand EgoController::Control(const EgoState& ego, double target_speed_mps, int lane_command) {
  Localize(ego, lane_command);
  const int before = followed_;
  followed_ = Neighbour(ego, lane_command);
  const Polyline::Projection& projection = projections_.data()[followed_];
  if (followed_ != before && projection.distance > kChangeBegins) changing_lane_ = true;
  if (projection.distance < kChangeEnds) changing_lane_ = false;
  return {std::min(target_speed_mps, CurveSpeed(ego, projection)), Steer(ego, projection)};
}

void EgoController::Localize(const EgoState& ego, int lane_command) {
  const auto project = [&](size_t i) { projections_[i] = (*paths_)[i].centre.Project(ego.pose.position); };
  const auto current = static_cast<size_t>(current_);
  project(current);
  double nearest = projections_[current].distance - kHysteresis;
  // Nothing is nearer than that, and nobody asks for a neighbour.
  if (nearest <= 0.0 && lane_command == 0) return;
  for (size_t i = 0; i < paths_->size(); ++i) {
    if (i != current) project(i);
  }
  for (size_t i = 0; i < paths_->size(); ++i) {
    if (projections_[i].distance >= nearest || !Drivable(ego, i)) continue;
    nearest = projections_[i].distance;
    current_ = i;
  }
}

bool EgoController::Drivable(const EgoState& ego, size_t path) const {
  const Polyline::Projection& projection = projections_[path];
  const Polyline& line = (*paths_)[path].centre;
  if (projection.distance > kReach || projection.s >= line.length()) return false;
  return std::abs(WrapAngle(line.HeadingAt(projection.s) - ego.pose.heading)) < kAlignment;
}

int EgoController::Neighbour(const EgoState& ego, int lane_command) const {
  int best = current_;
  double best_side = std::numeric_limits<double>::infinity();
  for (size_t i = 0; lane_command != 0 && i < paths_->size(); ++i) {
    if (!Drivable(ego, i)) continue;
    const auto metre = static_cast<size_t>(projections_[i].s);
    const double side = lane_command * sides_->At(i, current_, metre);
    if (side > 0.0 && side < best_side) {
      best_side = side;
      best = i;
    }
  }
  return best;
}

double EgoController::Steer(const EgoState& ego, const Polyline::Projection& projection) const {
  const Polyline& line = followed_path().centre;
  const double distance = changing_lane_ ? ChangingDistance(ego.speed_mps) : KeepingDistance(ego.speed_mps);
  // The point of the path at that distance from the ego, were the path straight.
  const double ahead =
      std::sqrt(std::max(1.0, distance * distance - projection.distance * projection.distance));
  const Point target = ToLocal(ego.pose, line.At(projection.s + ahead));
  const double steering = std::atan(kWheelbase * 2.0 * target.y / Dot(target, target));
  if (!changing_lane_) return steering;
  const double turn = WrapAngle(line.HeadingAt(projection.s + ahead) - line.HeadingAt(projection.s));
  if (std::abs(turn) > kStraight * ahead) return steering;
  return std::clamp(steering, -kChangeSteering, kChangeSteering);
}

double EgoController::CurveSpeed(const EgoState& ego, const Polyline::Projection& projection) const {
  const std::vector<double>& caps = followed_path().speed_caps;
  const double lag_distance = kSpeedLag * ego.speed_mps;
  const double horizon = ego.speed_mps * ego.speed_mps / (2.0 * kCurveBraking) + lag_distance;
  double limit = std::numeric_limits<double>::infinity();
  const auto last = static_cast<size_t>(projection.s + horizon);
  for (auto i = static_cast<size_t>(projection.s); i <= last && i < caps.size(); ++i) {
    const double distance = std::max(0.0, i - projection.s - lag_distance);
    limit = std::min(limit, std::sqrt(caps[i] * caps[i] + 2.0 * kCurveBraking * distance));
  }
  return limit;
}

}  // namespace dadrl
