#include "actor/sim/route.h"

#include <algorithm>
#include <functional>
#include <numbers>

namespace dadrl {
namespace {

constexpr double kLaneChangeMetres = 30.0;
constexpr double kLaneChangeSpacing = 1.0;

const Lane& LaneAt(const RoadMap& map, int index) { return map.lanes()[static_cast<size_t>(index)]; }

// The lanes inside the junction from `from` (exclusive) to `to` (exclusive); false when nothing joins them.
bool FindInside(const RoadMap& map, int from, int to, std::vector<int>& inside) {
  for (const int next : LaneAt(map, from).successors) {
    if (next == to) return true;
    if (!LaneAt(map, next).internal) continue;
    inside.push_back(next);
    if (FindInside(map, next, to, inside)) return true;
    inside.pop_back();
  }
  return false;
}

bool SideBySide(const Lane& a, const Lane& b) { return a.edge == b.edge && std::abs(a.index - b.index) == 1; }

// Appends the part of `line` with arc length in [low, high].
void AppendPart(const Polyline& line, double low, double high, std::vector<Point>& points) {
  points.push_back(line.At(low));
  for (size_t i = 0; i < line.points().size(); ++i) {
    if (line.arc()[i] > low && line.arc()[i] < high) points.push_back(line.points()[i]);
  }
  points.push_back(line.At(high));
}

// From `low` of one lane over to its neighbour, in a cosine; returns where on the neighbour it ends.
double AppendLaneChange(const Polyline& from, const Polyline& to, double low, std::vector<Point>& points) {
  const double span = std::min(kLaneChangeMetres, from.length() - low);
  const int steps = std::max(1, static_cast<int>(span / kLaneChangeSpacing));
  for (int i = 0; i <= steps; ++i) {
    const double t = static_cast<double>(i) / steps;
    const Point source = from.At(low + t * span);
    const Point target = to.At(to.Project(source).s);
    points.push_back(source + (0.5 - 0.5 * std::cos(std::numbers::pi * t)) * (target - source));
  }
  return to.Project(points.back()).s;
}

}  // namespace

Result<std::vector<int>> ConnectLanes(const RoadMap& map, const std::vector<std::string>& lane_ids) {
  std::vector<int> lanes;
  for (const std::string& id : lane_ids) {
    const int lane = map.FindLane(id);
    if (lane < 0) return Fail(ErrorCode::kInvalidArgument, "lane '{}' is not in the network", id);
    if (!lanes.empty() && !SideBySide(LaneAt(map, lanes.back()), LaneAt(map, lane))) {
      std::vector<int> inside;
      if (!FindInside(map, lanes.back(), lane, inside)) {
        return Fail(ErrorCode::kInvalidArgument, "no connection leads from lane '{}' to lane '{}'",
                    LaneAt(map, lanes.back()).id, id);
      }
      lanes.insert(lanes.end(), inside.begin(), inside.end());
    }
    lanes.push_back(lane);
  }
  if (lanes.empty()) return Fail(ErrorCode::kInvalidArgument, "the route names no lane");
  return lanes;
}

Route::Route(const RoadMap& map, std::vector<int> lanes, Point start, Point goal) : lanes_(std::move(lanes)) {
  std::vector<Point> points;
  double low = LaneAt(map, lanes_.front()).centre.Project(start).s;
  for (size_t i = 0; i < lanes_.size(); ++i) {
    const Lane& lane = LaneAt(map, lanes_[i]);
    const bool last = i + 1 == lanes_.size();
    if (!last && SideBySide(lane, LaneAt(map, lanes_[i + 1]))) {
      low = AppendLaneChange(lane.centre, LaneAt(map, lanes_[i + 1]).centre, low, points);
      continue;
    }
    const double high = last ? lane.centre.Project(goal).s : lane.centre.length();
    AppendPart(lane.centre, low, high, points);
    low = 0.0;
  }
  centre_ = Polyline(points);
  goal_ = centre_.points().back();
  MarkLanesOnRoute(map);
}

void Route::MarkLanesOnRoute(const RoadMap& map) {
  std::vector<std::string> edges;
  for (const int lane : lanes_) {
    const Lane& it = LaneAt(map, lane);
    if (!it.internal && (edges.empty() || edges.back() != it.edge)) edges.push_back(it.edge);
  }
  on_route_.assign(map.lanes().size(), false);
  for (const int lane : lanes_) on_route_[static_cast<size_t>(lane)] = true;
  // True when `lane`, inside a junction, leads to `edge`; marks the lanes on the way.
  std::function<bool(int, const std::string&)> leads_to = [&](int lane, const std::string& edge) {
    bool leads = false;
    for (const int next : LaneAt(map, lane).successors) {
      const Lane& it = LaneAt(map, next);
      if (!it.internal) {
        leads |= it.edge == edge;
      } else if (leads_to(next, edge)) {
        on_route_[static_cast<size_t>(next)] = leads = true;
      }
    }
    return leads;
  };
  for (size_t i = 0; i < edges.size(); ++i) {
    for (size_t lane = 0; lane < map.lanes().size(); ++lane) {
      if (map.lanes()[lane].edge != edges[i]) continue;
      on_route_[lane] = true;
      if (i + 1 < edges.size()) leads_to(static_cast<int>(lane), edges[i + 1]);
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
