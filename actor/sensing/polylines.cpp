#include "actor/sensing/polylines.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>

#include "actor/sensing/features.h"
#include "actor/sensing/localization.h"

namespace dadrl {
namespace {

constexpr int kPoints = DrivingShape::kWayPoints;
constexpr size_t kFeatures = DrivingShape::kPointFeatures;
constexpr size_t kWayFloats = kFeatures * kPoints;
constexpr double kSpacing = 1.0;  // metres

void WriteAbsent(std::span<float> way, int from) {
  for (size_t i = static_cast<size_t>(from) * kFeatures; i < kWayFloats; ++i) {
    way[i] = i % kFeatures == 0 ? 1.0f : 0.0f;
  }
}

void WritePoint(const LocalFrame& frame, Point point, double heading, std::span<float> way, int index) {
  const Point local = frame.ToLocal(point);
  const Point direction = Forward(heading - frame.pose.heading);
  float* const out = way.data() + static_cast<size_t>(index) * kFeatures;
  out[0] = 0.0f;
  out[1] = feature::Scaled(local.x, feature::kPosition);
  out[2] = feature::Scaled(local.y, feature::kPosition);
  out[3] = static_cast<float>(direction.x);
  out[4] = static_cast<float>(direction.y);
}

const Lane& LaneAt(const RoadMap& map, int lane) { return map.lanes()[static_cast<size_t>(lane)]; }

// Of the lanes behind `lane`: the straightest, and the one that is straightest but for it; -1 where there is
// none.
struct Branches {
  int straightest = -1;
  int next = -1;
};

Branches BranchesOf(const RoadMap& map, int lane) {
  const Polyline& centre = LaneAt(map, lane).centre;
  const double heading = centre.HeadingAt(centre.length());
  // Where it leads to: the lanes inside a junction begin alike.
  const auto turn = [&](int successor) {
    const Polyline& line = LaneAt(map, successor).centre;
    return std::abs(WrapAngle(line.HeadingAt(line.length()) - heading));
  };
  Branches branches;
  for (const int successor : LaneAt(map, lane).successors) {
    if (branches.straightest < 0 || turn(successor) < turn(branches.straightest)) {
      branches.next = branches.straightest;
      branches.straightest = successor;
    } else if (branches.next < 0 || turn(successor) < turn(branches.next)) {
      branches.next = successor;
    }
  }
  return branches;
}

// Writes the way from `s` of `lane` on; at the first fork the straightest branch, or the next with
// `take_next`. Whether there was a fork.
bool WriteWay(const RoadMap& map, const LocalFrame& frame, int lane, double s, bool take_next,
              std::span<float> way) {
  bool forked = false;
  for (int i = 0; i < kPoints; ++i) {
    for (s += kSpacing; s > LaneAt(map, lane).centre.length();) {
      s -= LaneAt(map, lane).centre.length();
      const Branches branches = BranchesOf(map, lane);
      const bool fork = !forked && branches.next >= 0;
      forked |= fork;
      lane = fork && take_next ? branches.next : branches.straightest;
      if (lane < 0) {
        WriteAbsent(way, i);
        return forked;
      }
    }
    const Polyline& centre = LaneAt(map, lane).centre;
    WritePoint(frame, centre.At(s), centre.HeadingAt(s), way, i);
  }
  return forked;
}

// The lane to the left of `lane`, else to the right; nothing on a road of one lane.
std::optional<int> LaneBeside(const RoadMap& map, int lane) {
  const std::span<const int> lanes = map.LanesOfEdge(LaneAt(map, lane).edge);
  const auto here = std::ranges::find(lanes, lane);
  if (here == lanes.end() || lanes.size() < 2) return std::nullopt;
  return here + 1 != lanes.end() ? *(here + 1) : *(here - 1);
}

}  // namespace

void WriteNoWays(std::span<float> out) {
  for (; !out.empty(); out = out.subspan(kWayFloats)) WriteAbsent(out.first(kWayFloats), 0);
}

void Polylines::WriteEgo(const EgoState& ego, double route_s, std::span<float> out) const {
  assert(out.size() == DrivingShape::kWays * kWayFloats);
  const LocalFrame frame(ego.pose);
  const Polyline& centre = route_.centre();
  for (int i = 0; i < kPoints; ++i) {
    const double s = route_s + kSpacing * (i + 1);
    if (s > centre.length()) {
      WriteAbsent(out, i);
      break;
    }
    WritePoint(frame, centre.At(s), centre.HeadingAt(s), out, i);
  }
  const std::span<float> along_lane = out.subspan(kWayFloats);
  const auto lane = map_.NearestLane(ego.pose.position, ego.pose.heading, kLaneSearchRadius, ego.elevation_m);
  if (!lane) return WriteNoWays(along_lane);
  WriteWay(map_, frame, lane->lane, lane->s, false, along_lane);
}

void Polylines::WriteVehicle(const EgoState& ego, const SocialVehicle& vehicle, std::span<float> out) const {
  assert(out.size() == DrivingShape::kWays * kWayFloats);
  const LocalFrame frame(ego.pose);
  const auto lane =
      map_.NearestLane(vehicle.pose.position, vehicle.pose.heading, kLaneSearchRadius, vehicle.elevation_m);
  if (!lane) return WriteNoWays(out);
  const std::span<float> second = out.subspan(kWayFloats);
  if (WriteWay(map_, frame, lane->lane, lane->s, false, out)) {
    WriteWay(map_, frame, lane->lane, lane->s, true, second);
  } else if (const auto beside = LaneBeside(map_, lane->lane)) {
    const double s = LaneAt(map_, *beside).centre.Project(vehicle.pose.position).s;
    WriteWay(map_, frame, *beside, s, false, second);
  } else {
    WriteNoWays(second);
  }
}

}  // namespace dadrl
