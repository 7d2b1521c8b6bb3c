#include "actor/ego/paths.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "actor/ego/smooth_line.h"

namespace dadrl {
namespace {

// What the paper's controller allows (paper code): slower than 5.56 m/s in a tight turn, 6.94 m/s in a wide
// one.
constexpr double kTightRadius = 8.0;
constexpr double kTightSpeed = 5.56;
constexpr double kWideRadius = 15.0;
constexpr double kWideSpeed = 6.94;
// A radius is taken over twice this length, in whole metres, and over the whole of a junction's lane.
constexpr int kCurveWindow = 3;
// Paths are told apart up to this many metres ahead, by this much.
constexpr size_t kForkLookahead = 24;
constexpr double kForkOffset = 0.5;
constexpr double kNoCap = std::numeric_limits<double>::infinity();

// Lowers the caps from metre `low` to metre `high` to what the turn between them allows.
void CapTurn(const Polyline& line, int low, int high, std::vector<double>& caps) {
  const double turn = std::abs(WrapAngle(line.HeadingAt(high) - line.HeadingAt(low)));
  if (turn * kWideRadius <= high - low) return;
  const double cap = turn * kTightRadius > high - low ? kTightSpeed : kWideSpeed;
  for (int i = low; i <= high; ++i) {
    double& at = caps.data()[i];
    at = std::min(at, cap);
  }
}

std::vector<double> SpeedCaps(const RoadMap& map, const std::vector<int>& lanes, const Polyline& line) {
  const auto last = static_cast<int>(line.length());
  std::vector<double> caps(static_cast<size_t>(last) + 1, kNoCap);
  for (int s = 0; s <= last; ++s) {
    CapTurn(line, std::max(0, s - kCurveWindow), std::min(last, s + kCurveWindow), caps);
  }
  for (const int lane : lanes) {
    if (!map.lane(lane).internal) continue;
    const std::vector<Point>& centre = map.lane(lane).centre.points();
    CapTurn(line, static_cast<int>(line.Project(centre.front()).s),
            std::min(last, static_cast<int>(std::ceil(line.Project(centre.back()).s))), caps);
  }
  return caps;
}

Path MakePath(const RoadMap& map, LaneSequence lanes) {
  std::vector<Point> points;
  for (const int lane : lanes) {
    const std::vector<Point>& centre = map.lane(lane).centre.points();
    points.insert(points.end(), centre.begin(), centre.end());
  }
  Path path{std::move(lanes), SmoothLine(Polyline(points)), {}};
  path.speed_caps = SpeedCaps(map, path.lanes, path.centre);
  return path;
}

// How far metre `metre` of `path` is to the left of `other`.
double Offset(const Path& path, const Path& other, size_t metre) {
  return other.centre.Project(path.centre.At(metre)).lateral;
}

}  // namespace

std::vector<Path> FindPaths(const RoadMap& map, const Route& route) {
  std::vector<Path> paths;
  for (LaneSequence& lanes : FindLaneSequences(map, route)) paths.push_back(MakePath(map, std::move(lanes)));
  return paths;
}

int PathOfRoute(const std::vector<Path>& paths, const Route& route) {
  const auto common = [&](const Path& path) {
    const auto parted =
        std::mismatch(path.lanes.begin(), path.lanes.end(), route.lanes().begin(), route.lanes().end());
    return parted.first - path.lanes.begin();
  };
  const auto best = std::max_element(paths.begin(), paths.end(),
                                     [&](const Path& a, const Path& b) { return common(a) < common(b); });
  return best - paths.begin();
}

PathSides::PathSides(const std::vector<Path>& paths) : paths_(paths), sides_(paths.size() * paths.size()) {}

double PathSides::At(int path, int other, size_t metre) {
  const Path& from = paths_.data()[path];
  const Path& to = paths_.data()[other];
  std::vector<double>& sides = sides_.data()[path * std::ssize(paths_) + other];
  const size_t metres = from.speed_caps.size();
  if (sides.empty()) sides.assign(metres, std::numeric_limits<double>::quiet_NaN());
  double& side = sides[metre];
  if (!std::isnan(side)) return side;
  side = 0.0;
  for (size_t ahead = metre; side == 0.0 && ahead < std::min(metres, metre + kForkLookahead + 1); ++ahead) {
    const double offset = Offset(from, to, ahead);
    if (std::abs(offset) > kForkOffset) side = offset;
  }
  return side;
}

}  // namespace dadrl
