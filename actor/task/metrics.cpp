#include "actor/task/metrics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dadrl {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;
constexpr double kObstacleRadius = 30.0;
constexpr double kObstacleSeconds = 3.0;
constexpr double kObstacleBearing = 40.0 * kRadians;
constexpr double kObstacleHeading = 179.0 * kRadians;
constexpr double kObstacleDecay = 0.05;      // per metre
constexpr double kComfortJerk = 0.9;         // m/s^3, in each direction
constexpr double kSpeedingSaturation = 0.5;  // excess as a fraction of the limit

}  // namespace

double ObstacleCost(const WorldState& world) {
  const EgoState& ego = world.ego;
  const double reach = std::min(kObstacleRadius, kObstacleSeconds * ego.speed_mps);
  double cost = 0.0;
  for (const SocialVehicle& vehicle : world.vehicles) {
    const Point offset = vehicle.pose.position - ego.pose.position;
    const double distance = std::sqrt(Dot(offset, offset));
    if (distance > reach) continue;
    const Point local = ToLocal(ego.pose, vehicle.pose.position);
    if (std::abs(std::atan2(local.y, local.x)) > kObstacleBearing) continue;
    if (std::abs(WrapAngle(vehicle.pose.heading - ego.pose.heading)) > kObstacleHeading) continue;
    cost = std::max(cost, std::exp(-kObstacleDecay * distance));
  }
  return cost;
}

double JerkCost(const EgoState& ego) {
  return std::min(std::hypot(ego.jerk_lon, ego.jerk_lat) / std::hypot(kComfortJerk, kComfortJerk), 1.0);
}

double LaneOffsetCost(const EgoLocation& location, const RoadMap& map) {
  if (location.lane_index < 0) return 0.0;
  const double half_width = map.lane(location.nearest->lane).width / 2;
  const double offset = location.nearest->distance / half_width;
  return std::min(offset * offset, 1.0);
}

double SpeedingCost(double speed_mps, double limit) {
  if (limit <= 0.0 || speed_mps <= limit) return 0.0;
  const double excess = std::min((speed_mps - limit) / (kSpeedingSaturation * limit), 1.0);
  return excess * excess;
}

void EpisodeMetrics::Step(const WorldState& world, const EgoLocation& location, const Events& events) {
  ++sums_.steps;
  sums_.speed += world.ego.speed_mps;
  sums_.obstacle += ObstacleCost(world);
  sums_.jerk += JerkCost(world.ego);
  sums_.lane_offset += LaneOffsetCost(location, map_);
  sums_.speeding += SpeedingCost(world.ego.speed_mps, location.speed_limit);
  sums_.wrong_way += events.wrong_way ? 1.0 : 0.0;
}

void EpisodeMetrics::Finish(int max_steps, EpisodeSummary& summary) const {
  const double steps = std::max(sums_.steps, 1);
  summary.mean_speed_mps = sums_.speed / steps;
  summary.obstacle_cost = sums_.obstacle / steps;
  summary.jerk_cost = sums_.jerk / steps;
  summary.lane_offset_cost = sums_.lane_offset / steps;
  summary.humanness_error = (summary.obstacle_cost + summary.jerk_cost + summary.lane_offset_cost) / 3;
  summary.rule_violation = (sums_.speeding + sums_.wrong_way) / steps / 2;
  const bool success = summary.outcome == Outcome::kSuccess;
  summary.distance_to_destination = success ? 0.0 : std::clamp(1.0 - summary.progress, 0.0, 1.0);
  summary.time_cost = success ? std::min(1.0, 1.0 * summary.steps / max_steps) : 1.0;
  summary.overall_score = 1.0 - (summary.distance_to_destination + summary.time_cost +
                                 summary.humanness_error + summary.rule_violation) /
                                    4;
}

}  // namespace dadrl
