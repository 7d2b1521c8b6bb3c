#include "actor/ego/paths.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
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

const Lane& LaneAt(const RoadMap& map, int lane) { return map.lanes()[static_cast<size_t>(lane)]; }

bool Contains(const std::vector<int>& lanes, int lane) {
  return std::find(lanes.begin(), lanes.end(), lane) != lanes.end();
}

// The ways from `lane` through the junction behind it to the next lanes outside, these included.
void FindCrossings(const RoadMap& map, int lane, std::vector<int>& way, std::vector<std::vector<int>>& ways) {
  for (const int next : LaneAt(map, lane).successors) {
    way.push_back(next);
    if (LaneAt(map, next).internal) {
      FindCrossings(map, next, way, ways);
    } else {
      ways.push_back(way);
    }
    way.pop_back();
  }
}

bool StaysOnRoute(const Route& route, const std::vector<int>& way) {
  return std::all_of(way.begin(), way.end(), [&](int lane) { return route.OnRoute(lane); });
}

// Extends `lanes` branch by branch; each complete sequence goes to `sequences`.
void Extend(const RoadMap& map, const Route& route, std::vector<int>& lanes,
            std::vector<std::vector<int>>& sequences) {
  std::vector<std::vector<int>> ways;
  std::vector<int> way;
  FindCrossings(map, lanes.back(), way, ways);
  // A ring would be followed for ever.
  std::erase_if(ways, [&](const auto& it) { return Contains(lanes, it.back()); });
  const bool any_on_route =
      std::any_of(ways.begin(), ways.end(), [&](const auto& it) { return StaysOnRoute(route, it); });
  if (any_on_route) std::erase_if(ways, [&](const auto& it) { return !StaysOnRoute(route, it); });
  if (ways.empty()) sequences.push_back(lanes);
  for (const std::vector<int>& it : ways) {
    const size_t before = lanes.size();
    lanes.insert(lanes.end(), it.begin(), it.end());
    Extend(map, route, lanes, sequences);
    lanes.resize(before);
  }
}

// A lane beside one of the sequences that no sequence drives on; -1 when there is none.
int UncoveredLane(const RoadMap& map, const std::vector<std::vector<int>>& sequences) {
  std::set<int> covered;
  std::set<std::string> edges;
  for (const std::vector<int>& sequence : sequences) {
    for (const int lane : sequence) {
      covered.insert(lane);
      if (!LaneAt(map, lane).internal) edges.insert(LaneAt(map, lane).edge);
    }
  }
  for (size_t lane = 0; lane < map.lanes().size(); ++lane) {
    if (edges.contains(map.lanes()[lane].edge) && !covered.contains(static_cast<int>(lane))) {
      return static_cast<int>(lane);
    }
  }
  return -1;
}

// Lowers the caps from metre `low` to metre `high` to what the turn between them allows.
void CapTurn(const Polyline& line, int low, int high, std::vector<double>& caps) {
  const double turn = std::abs(WrapAngle(line.HeadingAt(high) - line.HeadingAt(low)));
  if (turn * kWideRadius <= high - low) return;
  const double cap = turn * kTightRadius > high - low ? kTightSpeed : kWideSpeed;
  for (int i = low; i <= high; ++i) {
    caps[static_cast<size_t>(i)] = std::min(caps[static_cast<size_t>(i)], cap);
  }
}

std::vector<double> SpeedCaps(const RoadMap& map, const std::vector<int>& lanes, const Polyline& line) {
  const auto last = static_cast<int>(line.length());
  std::vector<double> caps(static_cast<size_t>(last) + 1, kNoCap);
  for (int s = 0; s <= last; ++s) {
    CapTurn(line, std::max(0, s - kCurveWindow), std::min(last, s + kCurveWindow), caps);
  }
  for (const int lane : lanes) {
    if (!LaneAt(map, lane).internal) continue;
    const std::vector<Point>& centre = LaneAt(map, lane).centre.points();
    CapTurn(line, static_cast<int>(line.Project(centre.front()).s),
            std::min(last, static_cast<int>(std::ceil(line.Project(centre.back()).s))), caps);
  }
  return caps;
}

Path MakePath(const RoadMap& map, std::vector<int> lanes) {
  std::vector<Point> points;
  for (const int lane : lanes) {
    const std::vector<Point>& centre = LaneAt(map, lane).centre.points();
    points.insert(points.end(), centre.begin(), centre.end());
  }
  Path path{std::move(lanes), SmoothLine(Polyline(points)), {}, {}};
  path.speed_caps = SpeedCaps(map, path.lanes, path.centre);
  return path;
}

std::vector<double> SidesOf(const Path& path, const Path& other) {
  std::vector<double> offsets;
  for (size_t i = 0; i < path.speed_caps.size(); ++i) {
    offsets.push_back(other.centre.Project(path.centre.At(static_cast<double>(i))).lateral);
  }
  std::vector<double> sides(offsets.size(), 0.0);
  for (size_t i = 0; i < sides.size(); ++i) {
    const auto begin = offsets.begin() + static_cast<long>(i);
    const auto end = offsets.begin() + static_cast<long>(std::min(offsets.size(), i + kForkLookahead + 1));
    const auto parted =
        std::find_if(begin, end, [](double offset) { return std::abs(offset) > kForkOffset; });
    if (parted != end) sides[i] = *parted;
  }
  return sides;
}

}  // namespace

std::vector<Path> FindPaths(const RoadMap& map, const Route& route) {
  std::vector<std::vector<int>> sequences;
  for (int start = route.lanes().front(); start >= 0; start = UncoveredLane(map, sequences)) {
    std::vector<int> lanes{start};
    Extend(map, route, lanes, sequences);
  }
  std::vector<Path> paths;
  paths.reserve(sequences.size());
  for (std::vector<int>& sequence : sequences) paths.push_back(MakePath(map, std::move(sequence)));
  for (Path& path : paths) {
    for (const Path& other : paths) path.sides.push_back(SidesOf(path, other));
  }
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
  return static_cast<int>(best - paths.begin());
}

}  // namespace dadrl
