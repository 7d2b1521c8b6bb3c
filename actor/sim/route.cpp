#include "actor/sim/route.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <numbers>

namespace dadrl {
namespace {

constexpr double kLaneChangeMetres = 30.0;
constexpr double kLaneChangeSpacing = 1.0;

bool SideBySide(const Lane& a, const Lane& b) { return a.edge == b.edge && std::abs(a.index - b.index) == 1; }

struct Line {
  std::vector<Point> points;
  std::vector<double> elevations;

  void Append(Point point, double elevation) {
    points.push_back(point);
    elevations.push_back(elevation);
  }
};

// Appends the part of `from` with arc length in [low, high].
void AppendPart(const Polyline& from, double low, double high, Line& line) {
  line.Append(from.At(low), from.ElevationAt(low));
  for (size_t i = 0; i < from.points().size(); ++i) {
    const double s = from.arc()[i];
    if (s > low && s < high) line.Append(from.points()[i], from.ElevationAt(s));
  }
  line.Append(from.At(high), from.ElevationAt(high));
}

// From `low` of one lane over to its neighbour, in a cosine; returns where on the neighbour it ends.
double AppendLaneChange(const Polyline& from, const Polyline& to, double low, Line& line) {
  const double span = std::min(kLaneChangeMetres, from.length() - low);
  const int steps = std::max(1, static_cast<int>(span / kLaneChangeSpacing));
  for (int i = 0; i <= steps; ++i) {
    const double t = 1.0 * i / steps;
    const Point source = from.At(low + t * span);
    const Point target = to.At(to.Project(source).s);
    line.Append(source + (0.5 - 0.5 * std::cos(std::numbers::pi * t)) * (target - source),
                from.ElevationAt(low + t * span));
  }
  return to.Project(line.points.back()).s;
}

}  // namespace

Result<std::vector<int>> ConnectLanes(const RoadMap& map, const std::vector<std::string>& lane_ids) {
  std::vector<int> lanes;
  for (const std::string& id : lane_ids) {
    const int lane = map.FindLane(id);
    if (lane < 0) return Fail(ErrorCode::kInvalidArgument, "lane '{}' is not in the network", id);
    if (!lanes.empty() && !SideBySide(map.lane(lanes.back()), map.lane(lane))) {
      const auto ways = map.CrossingsFrom(lanes.back());
      const auto way = std::ranges::find_if(ways, [&](const auto& it) { return it.back() == lane; });
      if (way == ways.end()) {
        std::vector<std::string> reached;
        for (const std::vector<int>& it : ways) reached.push_back(map.lane(it.back()).id);
        return Fail(ErrorCode::kInvalidArgument,
                    "no connection leads from lane '{}' to lane '{}'; it leads to: {}",
                    map.lane(lanes.back()).id, id,
                    reached.empty() ? "none" : fmt::format("{}", fmt::join(reached, ", ")));
      }
      lanes.insert(lanes.end(), way->begin(), way->end() - 1);
    }
    lanes.push_back(lane);
  }
  if (lanes.empty()) return Fail(ErrorCode::kInvalidArgument, "the route names no lane");
  return lanes;
}

Route::Route(const RoadMap& map, std::vector<int> lanes, Point start, Point goal) : lanes_(std::move(lanes)) {
  Line line;
  double low = map.lane(lanes_.front()).centre.Project(start).s;
  for (size_t i = 0; i < lanes_.size(); ++i) {
    const Lane& lane = map.lane(lanes_[i]);
    const bool last = i + 1 == lanes_.size();
    if (!last && SideBySide(lane, map.lane(lanes_[i + 1]))) {
      low = AppendLaneChange(lane.centre, map.lane(lanes_[i + 1]).centre, low, line);
      continue;
    }
    const double high = last ? lane.centre.Project(goal).s : lane.centre.length();
    AppendPart(lane.centre, low, high, line);
    low = 0.0;
  }
  centre_ = Polyline(line.points, line.elevations);
  goal_ = centre_.points().back();
  MarkLanesOnRoute(map);
}

void Route::MarkLanesOnRoute(const RoadMap& map) {
  std::vector<std::string> edges;
  for (const int lane : lanes_) {
    const Lane& it = map.lane(lane);
    if (!it.internal && (edges.empty() || edges.back() != it.edge)) edges.push_back(it.edge);
  }
  on_route_.assign(map.lanes().size(), false);
  for (const int lane : lanes_) on_route_[static_cast<size_t>(lane)] = true;
  for (size_t i = 0; i < edges.size(); ++i) {
    for (const int lane : map.LanesOfEdge(edges[i])) {
      on_route_[static_cast<size_t>(lane)] = true;
      if (i + 1 == edges.size()) continue;
      for (const std::vector<int>& way : map.CrossingsFrom(lane)) {
        if (map.lane(way.back()).edge != edges[i + 1]) continue;
        for (const int inside : way) on_route_[static_cast<size_t>(inside)] = true;
      }
    }
  }
}

bool Route::OnRoute(int lane) const {
  return lane >= 0 && static_cast<size_t>(lane) < on_route_.size() && on_route_[static_cast<size_t>(lane)];
}

double Route::Progress(Point point) const {
  return std::clamp(centre_.Project(point).s / centre_.length(), 0.0, 1.0);
}

}  // namespace dadrl
