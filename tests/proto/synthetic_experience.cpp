#include "tests/proto/synthetic_experience.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "tests/driving_columns.h"

namespace dadrl {
namespace {

struct Point {
  double x = 0.0;
  double y = 0.0;
};

struct Pose {
  Point at;
  double heading = 0.0;

  Point ToLocal(const Point& p) const {
    const double dx = p.x - at.x;
    const double dy = p.y - at.y;
    return {dx * std::cos(heading) + dy * std::sin(heading), dy * std::cos(heading) - dx * std::sin(heading)};
  }
};

// To the frame that `pose` is given in. Sine and cosine are taken once: a plane has 16,384 pixels.
struct ToGlobal {
  explicit ToGlobal(const Pose& pose)
      : at(pose.at), cosine(std::cos(pose.heading)), sine(std::sin(pose.heading)) {}
  Point operator()(const Point& p) const {
    return {at.x + p.x * cosine - p.y * sine, at.y + p.x * sine + p.y * cosine};
  }

  Point at;
  double cosine;
  double sine;
};

// A main road along x, two lanes each way, and an arm that joins it from below.
bool Drivable(const Point& p) {
  const bool main_road = std::abs(p.y) < 6.4;
  const bool arm = std::abs(p.x) < 6.4 && p.y < 0.0;
  const bool corner =
      p.y < -6.4 && p.y > -12.0 && std::abs(p.x) < 6.4 + 0.15 * (12.0 + p.y) * (12.0 + p.y) / 5.6;
  return main_road || arm || corner;
}

// From the arm up and left into the far lane: distance of `p` from that line, and how far along it is.
double RouteDistance(const Point& p, double& along) {
  constexpr double kRadius = 10.0;
  const Point centre{1.6 - kRadius, 1.6 - kRadius};
  if (p.y < centre.y) {
    along = p.y - centre.y;
    return std::abs(p.x - 1.6);
  }
  if (p.x < centre.x) {
    along = kRadius * std::numbers::pi / 2 + centre.x - p.x;
    return std::abs(p.y - 1.6);
  }
  along = kRadius * std::atan2(p.y - centre.y, p.x - centre.x);
  return std::abs(std::hypot(p.x - centre.x, p.y - centre.y) - kRadius);
}

void Paint(const Pose& ego, std::span<uint8_t> context) {
  constexpr int kSize = DrivingShape::kContextSize;
  constexpr double kMetresPerPixel = 50.0 / kSize;
  double ego_along = 0.0;
  RouteDistance(ego.at, ego_along);
  const ToGlobal to_global(ego);
  for (int row = 0; row < kSize; ++row) {
    for (int column = 0; column < kSize; ++column) {
      const Point local{25.0 - (row + 0.5) * kMetresPerPixel, 25.0 - (column + 0.5) * kMetresPerPixel};
      const Point p = to_global(local);
      const auto byte = static_cast<size_t>(row * 16 + column / 8);
      const auto bit = static_cast<uint8_t>(1u << (column % 8));
      if (Drivable(p)) context[byte] |= bit;
      double along = 0.0;
      const double distance = RouteDistance(p, along);
      if (distance < 1.0 && along > ego_along && along < ego_along + 32.0) context[2048 + byte] |= bit;
    }
  }
}

void PutSeven(std::span<float> row, const Point& at, double heading, double speed, int lane) {
  row[0] = 0.0f;
  row[1] = static_cast<float>(at.x / 30.0);
  row[2] = static_cast<float>(at.y / 30.0);
  row[3] = static_cast<float>(std::cos(heading));
  row[4] = static_cast<float>(std::sin(heading));
  row[5] = static_cast<float>(speed / 10.0);
  row[6] = static_cast<float>(lane) / 4.0f;
}

// Where a car of constant turn rate and acceleration was `ago` seconds ago.
struct Motion {
  Pose now;
  double speed = 0.0;
  double acceleration = 0.0;
  double turn_rate = 0.0;

  Pose Before(double ago) const {
    Pose pose = now;
    constexpr double kStep = 0.1;
    for (double t = 0.0; t < ago - 1e-9; t += kStep) {
      const double v = std::max(0.0, speed - acceleration * t);
      pose.at.x -= v * kStep * std::cos(pose.heading);
      pose.at.y -= v * kStep * std::sin(pose.heading);
      pose.heading -= turn_rate * kStep;
    }
    return pose;
  }
  double SpeedBefore(double ago) const { return std::max(0.0, speed - acceleration * ago); }
};

Motion RandomVehicle(Random& random) {
  Motion vehicle;
  const bool eastward = random.Uniform() < 0.5;
  const double lane = random.Uniform() < 0.5 ? 1.6 : 4.8;
  vehicle.now.at = {random.Uniform(-25.0, 25.0), eastward ? -lane : lane};
  vehicle.now.heading = eastward ? 0.0 : std::numbers::pi;
  vehicle.speed = random.Uniform(0.0, 13.0);
  vehicle.acceleration = random.Uniform(-2.0, 2.0);
  return vehicle;
}

}  // namespace

Observation SyntheticObservation(const DrivingShape& spec, Random& random) {
  Observation observation(spec);
  Motion ego;
  const double turned = random.Uniform(0.0, std::numbers::pi / 2);
  const bool turning = random.Uniform() < 0.5;
  ego.now = {{1.6, random.Uniform(-40.0, -8.4)}, std::numbers::pi / 2};
  if (turning)
    ego.now = {{-8.4 + 10.0 * std::cos(turned), -8.4 + 10.0 * std::sin(turned)},
               std::numbers::pi / 2 + turned};
  ego.speed = random.Uniform(0.0, 10.0);
  ego.acceleration = random.Uniform(-2.0, 2.0);
  ego.turn_rate = turning ? ego.speed / 10.0 : 0.0;
  Paint(ego.now, ContextOf(observation));

  const auto history = static_cast<size_t>(spec.history);
  const int present = static_cast<int>(random.Below(static_cast<uint64_t>(spec.vehicles) + 1));
  for (int v = 0; v < spec.vehicles; ++v) {
    const Motion vehicle = RandomVehicle(random);
    for (size_t h = 0; h < history; ++h) {
      const double ago = 0.5 * static_cast<double>(history - 1 - h);
      const auto row = VehiclesOf(observation).subspan((static_cast<size_t>(v) * history + h) * 7, 7);
      const Pose pose = vehicle.Before(ago);
      if (v >= present) {
        row[0] = 1.0f;
      } else {
        PutSeven(row, ego.now.ToLocal(pose.at), pose.heading - ego.now.heading, vehicle.SpeedBefore(ago),
                 std::abs(pose.at.y) < 3.2 ? 0 : 1);
      }
    }
  }
  for (size_t h = 0; h < history; ++h) {
    const double ago = 0.5 * static_cast<double>(history - 1 - h);
    const auto row = EgoOf(observation).subspan(h * 20, 20);
    const Pose pose = ego.Before(ago);
    PutSeven(row, ego.now.ToLocal(pose.at), pose.heading - ego.now.heading, ego.SpeedBefore(ago), 0);
    const Point goal = pose.ToLocal({-60.0, 1.6});
    const double values[] = {turning ? 0.4 : 0.0,
                             ego.turn_rate,
                             ego.SpeedBefore(ago) / 10.0,
                             0.0,
                             (ego.acceleration + random.Uniform(-0.05, 0.05)) / 5.0,
                             ego.speed * ego.turn_rate / 5.0,
                             random.Uniform(-1.0, 1.0),
                             0.0,
                             0.0,
                             1.34,
                             goal.x / 100.0,
                             goal.y / 100.0,
                             random.Uniform(0.3, 0.31)};
    std::copy(std::begin(values), std::end(values), row.begin() + 7);
  }
  return observation;
}

Observation NoiseObservation(const DrivingShape& spec, Random& random) {
  Observation observation(spec);
  const auto fill = [&](std::span<float> values) {
    for (float& value : values) value = static_cast<float>(random.Normal() * std::exp(8.0 * random.Normal()));
  };
  fill(VehiclesOf(observation));
  fill(EgoOf(observation));
  for (uint8_t& byte : ContextOf(observation)) byte = static_cast<uint8_t>(random.Next());
  return observation;
}

std::vector<std::byte> MakeSyntheticChunk(const DrivingShape& spec, const SyntheticChunk& chunk,
                                          uint64_t seed) {
  Random random(seed);
  ChunkBuilder builder(spec, chunk.floats);
  builder.Begin(chunk.episode, chunk.first_frame);
  for (int i = 0; i < chunk.frames; ++i) {
    const float part = static_cast<float>(chunk.first_frame + static_cast<uint32_t>(i)) / 1000.0f;
    builder.AddTransition(SyntheticObservation(spec, random), Action{part, -part},
                          (static_cast<float>(chunk.episode) + part) * 0x1p-10f,
                          i + 1 == chunk.frames ? chunk.end : uint8_t{0}, chunk.policy_version);
  }
  if (chunk.final_frame) builder.AddFinal(SyntheticObservation(spec, random));
  return builder.Finish(chunk.identity);
}

}  // namespace dadrl
