#include "actor/sensing/history.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "actor/sensing/features.h"
#include "common/step/driving_shape.h"

namespace dadrl {
namespace {

constexpr int kVehicleFeatures = DrivingShape::kVehicleFeatures;
constexpr int kEgoFeatures = DrivingShape::kEgoFeatures;
void WriteAbsent(float* row, int features) {
  std::fill_n(row, features, 0.0f);
  row[0] = 1.0f;
}

void WriteMotion(float* row, const LocalFrame& frame, const Pose& pose, double speed, int lane_index) {
  const Point local = frame.ToLocal(pose.position);
  const Point direction = Forward(pose.heading - frame.pose.heading);
  row[0] = 0.0f;
  row[1] = feature::Scaled(local.x, feature::kPosition);
  row[2] = feature::Scaled(local.y, feature::kPosition);
  row[3] = direction.x;
  row[4] = direction.y;
  row[5] = feature::Scaled(speed, feature::kSpeed);
  row[6] = feature::Scaled(lane_index, 1.0);
}

const SocialVehicle* Find(const std::vector<SocialVehicle>& vehicles, int id) {
  const auto it = std::ranges::find(vehicles, id, &SocialVehicle::id);
  return it == vehicles.end() ? nullptr : &*it;
}

}  // namespace

History::History(const ObservationConfig& config)
    : config_(config), ring_(static_cast<size_t>((config.history - 1) * config.history_stride + 1)) {}

void History::Push(const WorldState& world, const EgoLocation& location) {
  newest_ = (newest_ + 1) % ring_.size();
  count_ = std::min(count_ + 1, ring_.size());
  Scene& scene = ring_[newest_];
  scene.ego = world.ego;
  scene.location = location;
  scene.vehicles.assign(world.vehicles.begin(), world.vehicles.end());
}

const History::Scene* History::At(int age) const {
  const auto steps = static_cast<size_t>(age);
  return steps < count_ ? &ring_[(newest_ + ring_.size() - steps) % ring_.size()] : nullptr;
}

void History::SelectNearest() {
  const Scene& now = *At(0);
  nearest_.clear();
  for (const SocialVehicle& vehicle : now.vehicles) {
    const Point offset = vehicle.pose.position - now.ego.pose.position;
    const double squared = Dot(offset, offset);
    if (squared <= config_.radius_m * config_.radius_m) nearest_.emplace_back(squared, &vehicle);
  }
  const size_t kept = std::min(nearest_.size(), static_cast<size_t>(config_.vehicles));
  std::partial_sort(nearest_.begin(), nearest_.begin() + static_cast<std::ptrdiff_t>(kept), nearest_.end(),
                    [](const auto& a, const auto& b) {
                      return a.first != b.first ? a.first < b.first : a.second->id < b.second->id;
                    });
  nearest_.resize(kept);
}

void History::WriteVehicleRows(const SocialVehicle& now, const LocalFrame& frame, float* rows) const {
  const SocialVehicle* later = &now;
  for (int row = config_.history - 1; row >= 0; --row) {
    float* out = rows + row * kVehicleFeatures;
    if (later != nullptr && row < config_.history - 1) {
      const Scene* scene = At((config_.history - 1 - row) * config_.history_stride);
      const SocialVehicle* earlier = scene != nullptr ? Find(scene->vehicles, now.id) : nullptr;
      const bool looped = earlier != nullptr && earlier->trip != now.trip;
      later = looped ? nullptr : earlier;
    }
    if (later == nullptr) {
      WriteAbsent(out, kVehicleFeatures);
    } else {
      WriteMotion(out, frame, later->pose, later->speed_mps, later->lane_index);
    }
  }
}

void History::WriteVehicles(std::span<float> out) {
  const size_t block = static_cast<size_t>(config_.history * kVehicleFeatures);
  assert(count_ > 0 && out.size() == block * static_cast<size_t>(config_.vehicles));
  SelectNearest();
  const LocalFrame frame(At(0)->ego.pose);
  for (size_t slot = 0; std::cmp_less(slot, config_.vehicles); ++slot) {
    float* rows = out.data() + slot * block;
    if (slot < nearest_.size()) {
      WriteVehicleRows(*nearest_[slot].second, frame, rows);
    } else {
      for (int row = 0; row < config_.history; ++row) {
        WriteAbsent(rows + row * kVehicleFeatures, kVehicleFeatures);
      }
    }
  }
}

void History::WriteEgo(Point goal, std::span<float> out) const {
  assert(count_ > 0 && std::cmp_equal(out.size(), config_.history * kEgoFeatures));
  const LocalFrame frame(At(0)->ego.pose);
  const Point local_goal = frame.ToLocal(goal);
  for (int row = 0; row < config_.history; ++row) {
    float* f = out.data() + row * kEgoFeatures;
    const Scene* scene = At((config_.history - 1 - row) * config_.history_stride);
    if (scene == nullptr) {
      WriteAbsent(f, kEgoFeatures);
      continue;
    }
    const EgoState& ego = scene->ego;
    WriteMotion(f, frame, ego.pose, ego.speed_mps, scene->location.lane_index);
    f[7] = feature::Scaled(ego.steering_rad, feature::kSteering);
    f[8] = feature::Scaled(ego.yaw_rate, feature::kYawRate);
    f[9] = feature::Scaled(ego.velocity_lon, feature::kSpeed);
    f[10] = feature::Scaled(ego.velocity_lat, feature::kLateralSpeed);
    f[11] = feature::Scaled(ego.acceleration_lon, feature::kAcceleration);
    f[12] = feature::Scaled(ego.acceleration_lat, feature::kAcceleration);
    f[13] = feature::Scaled(ego.jerk_lon, feature::kJerk);
    f[14] = feature::Scaled(ego.jerk_lat, feature::kJerk);
    f[15] = feature::Scaled(ego.angular_acceleration, feature::kAngularAcceleration);
    f[16] = feature::Scaled(scene->location.speed_limit, feature::kSpeed);
    f[17] = feature::Scaled(local_goal.x, feature::kGoal);
    f[18] = feature::Scaled(local_goal.y, feature::kGoal);
    f[19] = scene->location.remaining;
  }
}

}  // namespace dadrl
