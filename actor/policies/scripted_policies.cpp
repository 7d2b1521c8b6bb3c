#include "actor/policies/scripted_policies.h"

namespace dadrl {
namespace {

constexpr double kOnRoute = 0.8;
constexpr uint64_t kActionStream = 0xac7;

}  // namespace

int LaneTowardsRoute(const DrivingEnvironment& environment) {
  const Polyline& centre = environment.route().centre();
  const double s = environment.location().route_s;
  const Pose on_route{centre.At(s), centre.HeadingAt(s)};
  const double lateral = ToLocal(on_route, environment.world().ego.pose.position).y;
  return lateral > kOnRoute ? -1 : lateral < -kOnRoute ? 1 : 0;
}

void RandomPolicy::BeginEpisode(uint64_t seed) { random_ = Random(DeriveSeed(seed, kActionStream)); }

Decision RandomPolicy::Decide(const DrivingEnvironment& environment) {
  const auto speed = static_cast<float>(random_.Uniform(-1.0, 1.0));
  const auto lane = static_cast<float>(random_.Uniform(-1.0, 1.0));
  return {CommandOf({speed, lane}, environment.config().task.max_speed_mps), hold_steps_};
}

Decision ConstantSpeedPolicy::Decide(const DrivingEnvironment& environment) {
  return {{speed_mps_, lane_ == Lane::kRoute ? LaneTowardsRoute(environment) : 0}, 1};
}

}  // namespace dadrl
