#include "actor/policies/predictive_policy.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "actor/policies/scripted_policies.h"
#include "actor/task/collision.h"
#include "actor/task/events.h"

namespace dadrl {
namespace {

constexpr std::array<double, 6> kSpeeds = {10.0, 8.0, 6.0, 4.0, 2.0, 0.0};
constexpr double kClearance = 0.8;  // metres between the boxes
constexpr double kRadius = 70.0;    // nobody comes from farther within the horizon

// A car behind in the ego's own lane will brake for it, unlike its prediction.
bool Follows(const Pose& ego, const Pose& other) {
  const Point local = ToLocal(ego, other.position);
  return local.x < 0.0 && std::abs(local.y) < kVehicleWidth &&
         std::abs(WrapAngle(other.heading - ego.heading)) < std::numbers::pi / 4;
}

}  // namespace

void PredictivePolicy::BeginEpisode(uint64_t seed) {
  std::ignore = seed;
  scenes_ = 0;
}

double PredictivePolicy::TurnRate(const SocialVehicle& vehicle, int step) const {
  const int age = std::min(scenes_, kTurnScenes);
  if (age == 0) return 0.0;
  const Scene& scene = past_[static_cast<size_t>((scenes_ - age) % kTurnScenes)];
  const auto it = std::ranges::find(scene.vehicles, vehicle.id, &SocialVehicle::id);
  if (it == scene.vehicles.end()) return 0.0;
  return WrapAngle(vehicle.pose.heading - it->pose.heading) / ((step - scene.step) * kStepSeconds);
}

void PredictivePolicy::Predict(const WorldState& world, int step) {
  others_.clear();
  for (const SocialVehicle& vehicle : world.vehicles) {
    if (Norm(vehicle.pose.position - world.ego.pose.position) > kRadius) continue;
    if (Follows(world.ego.pose, vehicle.pose)) continue;
    const double turn = TurnRate(vehicle, step) * kStepSeconds;
    const double advance = vehicle.speed_mps * kStepSeconds;
    Pose pose = vehicle.pose;
    Trajectory& trajectory = others_.emplace_back();
    for (OrientedBox& predicted : trajectory) {
      pose.position = pose.position + advance * Forward(pose.heading + turn / 2);
      pose.heading += turn;
      predicted = {pose, vehicle.length_m, vehicle.width_m};
    }
  }
  past_[static_cast<size_t>(scenes_ % kTurnScenes)] = {step, world.vehicles};
  ++scenes_;
}

int PredictivePolicy::ClearSteps(const DrivingEnvironment& environment, const DriveCommand& command) const {
  EgoController controller = environment.controller();
  EgoVehicle vehicle = environment.vehicle();
  for (int step = 0; step < kHorizonSteps; ++step) {
    const EgoCommand control = controller.Control(vehicle.state(), command.target_speed_mps, command.lane);
    vehicle.Step(control.target_speed_mps, control.target_steering_rad);
    const Point position = vehicle.state().pose.position;
    if (Norm(position - environment.route().goal()) <= kGoalRadius) return kHorizonSteps;
    if (environment.map().OffRoad(position, environment.world().ego.elevation_m)) return step;
    for (const Trajectory& other : others_) {
      if (BoxesWithin(EgoBox(vehicle.state().pose), other[static_cast<size_t>(step)], kClearance))
        return step;
    }
  }
  return kHorizonSteps;
}

Decision PredictivePolicy::Decide(const DrivingEnvironment& environment) {
  Predict(environment.world(), environment.summary().steps);
  const int towards_route = LaneTowardsRoute(environment);
  DriveCommand best;
  int best_clear = -1;
  for (const double speed : kSpeeds) {
    for (const int lane : {towards_route, 0}) {
      const DriveCommand command{speed, lane};
      const int clear = ClearSteps(environment, command);
      if (clear == kHorizonSteps) return {command, 1};
      // Of two that both end in contact the slower one ends softer.
      if (clear >= best_clear) {
        best = command;
        best_clear = clear;
      }
      if (towards_route == 0) break;
    }
  }
  return {best, 1};
}

}  // namespace dadrl
