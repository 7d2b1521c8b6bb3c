#include "actor/render/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "actor/sensing/features.h"
#include "actor/task/collision.h"

namespace dadrl {
namespace {

RewardTerms operator+(const RewardTerms& a, const RewardTerms& b) {
  return {.crash = a.crash + b.crash,
          .off_road = a.off_road + b.off_road,
          .goal = a.goal + b.goal,
          .progress = a.progress + b.progress,
          .speed = a.speed + b.speed,
          .off_route = a.off_route + b.off_route,
          .wrong_way = a.wrong_way + b.wrong_way,
          .slow = a.slow + b.slow};
}

// The vehicle at `local` in the ego's frame: an observation names none.
const SocialVehicle* VehicleAt(const WorldState& world, Point local) {
  constexpr double kTolerance = 0.1;
  const auto distance = [&](const SocialVehicle& vehicle) {
    return Norm(ToLocal(world.ego.pose, vehicle.pose.position) - local);
  };
  const auto nearest =
      std::min_element(world.vehicles.begin(), world.vehicles.end(),
                       [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  return nearest != world.vehicles.end() && distance(*nearest) < kTolerance ? &*nearest : nullptr;
}

// Row i of the observation's vehicles got `weights[i]`.
std::vector<Attention> NameAttention(const DrivingEnvironment& environment, std::span<const float> weights) {
  std::vector<Attention> named;
  const DrivingShape shape = DrivingShape::From(environment.config().observation);
  const std::span<const float> rows = environment.observation().floats(shape.vehicles_column);
  for (size_t i = 0; i < weights.size(); ++i) {
    const size_t newest = (i + 1) * static_cast<size_t>(shape.history) - 1;
    const float* const row = rows.data() + newest * DrivingShape::kVehicleFeatures;
    if (row[0] > 0.5f) continue;  // absent
    const Point local{row[1] * feature::kPosition, row[2] * feature::kPosition};
    if (const SocialVehicle* vehicle = VehicleAt(environment.world(), local)) {
      named.push_back({vehicle->id, weights[i]});
    }
  }
  return named;
}

Moment Capture(const DrivingEnvironment& environment) {
  Moment moment;
  moment.world = environment.world();
  moment.events = environment.last_step().events;
  moment.reward = environment.last_step().terms;
  const DrivingShape shape = DrivingShape::From(environment.config().observation);
  const std::span<const uint8_t> context = environment.observation().bits(shape.context_column);
  moment.context.assign(context.begin(), context.end());
  return moment;
}

// The nearest, as the summary's collision.
std::optional<int> VehicleTouched(const WorldState& world) {
  std::optional<int> touched;
  double nearest = std::numeric_limits<double>::infinity();
  for (const SocialVehicle& vehicle : world.vehicles) {
    const double distance = Norm(vehicle.pose.position - world.ego.pose.position);
    if (distance >= nearest || !BoxesWithin(EgoBox(world.ego.pose), vehicle.box(), kContactDistance))
      continue;
    nearest = distance;
    touched = vehicle.id;
  }
  return touched;
}

}  // namespace

Result<Recording> RecordEpisode(DrivingEnvironment& environment, DrivingPolicy& policy,
                                const std::string& policy_name, uint64_t seed) {
  DADRL_RETURN_IF_ERROR(environment.Reset(seed));
  policy.BeginEpisode(seed);
  Recording recording{.scenario = environment.config().scenario,
                      .policy = policy_name,
                      .map = environment.map(),
                      .route = environment.route(),
                      .max_speed_mps = environment.config().task.max_speed_mps,
                      .sensor_radius_m = environment.config().observation.radius_m,
                      .moments = {},
                      .summary = {},
                      .collided_with = {}};
  std::vector<Moment>& moments = recording.moments;
  moments.push_back(Capture(environment));
  while (!environment.last_step().ended()) {
    const Decision decision = policy.Decide(environment);
    if (!environment.sumo_drives()) moments.back().command = decision.command;
    moments.back().attention = NameAttention(environment, policy.attention());
    for (int step = 0; step < decision.steps && !environment.last_step().ended(); ++step) {
      DADRL_RETURN_IF_ERROR(environment.Drive(decision.command, 1));
      Moment moment = Capture(environment);
      moment.reward_so_far = moments.back().reward_so_far + moment.reward;
      moment.command = moments.back().command;
      moment.attention = moments.back().attention;
      moments.push_back(std::move(moment));
    }
  }
  recording.summary = environment.summary();
  if (recording.summary.outcome == Outcome::kCollision) {
    recording.collided_with = VehicleTouched(moments.back().world);
  }
  return recording;
}

std::string OutcomeSentence(const Recording& recording) {
  const double seconds = recording.summary.steps * kStepSeconds;
  switch (recording.summary.outcome) {
    case Outcome::kSuccess:
      return fmt::format("goal reached after {:.1f} s", seconds);
    case Outcome::kOffRoad:
      return fmt::format("left the road at {:.1f} s", seconds);
    case Outcome::kStagnation:
      return fmt::format("goal not reached within {:.1f} s", seconds);
    case Outcome::kCollision:
      return recording.collided_with
                 ? fmt::format("collision with car {} at {:.1f} s", *recording.collided_with, seconds)
                 : fmt::format("collision at {:.1f} s", seconds);
  }
  return {};
}

}  // namespace dadrl
