#include "actor/sim/road_map.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <unordered_map>

namespace dadrl {
namespace {

constexpr double kCellSize = 4.0;
// Centre lines nearer to each other than this count as equally near: lanes that fork run on top of each
// other.
constexpr double kTie = 0.01;
constexpr double kOffRoadMargin = 0.1;

}  // namespace

struct RoadMap::Grid {
  struct Segment {
    Point from;
    Point direction;  // unit
    double span = 0.0;
    double s = 0.0;  // arc length at `from`
    int lane = 0;
  };

  std::vector<Segment> segments;
  std::unordered_map<std::string, int> lane_by_id;
  Point origin;
  int columns = 0;
  int rows = 0;
  std::vector<std::vector<int32_t>> cells;
  double max_off_road_distance = 0.0;

  int Column(double x) const {
    return std::clamp(static_cast<int>(std::floor((x - origin.x) / kCellSize)), 0, columns - 1);
  }
  int Row(double y) const {
    return std::clamp(static_cast<int>(std::floor((y - origin.y) / kCellSize)), 0, rows - 1);
  }

  size_t Cell(int row, int column) const {
    return static_cast<size_t>(row) * static_cast<size_t>(columns) + static_cast<size_t>(column);
  }

  void AddLane(const Lane& lane, int index);
  void Bin();
  // Calls visit(segment, along, distance) for each segment within `radius`; a segment may come twice.
  template <typename Visit>
  void ForEachNear(Point point, double radius, Visit visit) const;
};

void RoadMap::Grid::AddLane(const Lane& lane, int index) {
  lane_by_id.emplace(lane.id, index);
  max_off_road_distance = std::max(max_off_road_distance, lane.width / 2.0 + kOffRoadMargin);
  const std::vector<Point>& points = lane.centre.points();
  const std::vector<double>& arc = lane.centre.arc();
  for (size_t i = 0; i + 1 < points.size(); ++i) {
    const double span = arc[i + 1] - arc[i];
    segments.push_back({points[i], (1.0 / span) * (points[i + 1] - points[i]), span, arc[i], index});
  }
}

void RoadMap::Grid::Bin() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Point low{kInfinity, kInfinity};
  Point high{-kInfinity, -kInfinity};
  for (const Segment& segment : segments) {
    for (const Point& p : {segment.from, segment.from + segment.span * segment.direction}) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
  }
  if (segments.empty()) low = high = Point{};
  origin = low;
  columns = static_cast<int>((high.x - low.x) / kCellSize) + 1;
  rows = static_cast<int>((high.y - low.y) / kCellSize) + 1;
  cells.assign(static_cast<size_t>(columns) * static_cast<size_t>(rows), {});
  for (size_t i = 0; i < segments.size(); ++i) {
    const Point a = segments[i].from;
    const Point b = a + segments[i].span * segments[i].direction;
    for (int row = Row(std::min(a.y, b.y)); row <= Row(std::max(a.y, b.y)); ++row) {
      for (int column = Column(std::min(a.x, b.x)); column <= Column(std::max(a.x, b.x)); ++column) {
        cells[Cell(row, column)].push_back(static_cast<int32_t>(i));
      }
    }
  }
}

template <typename Visit>
void RoadMap::Grid::ForEachNear(Point point, double radius, Visit visit) const {
  for (int row = Row(point.y - radius); row <= Row(point.y + radius); ++row) {
    for (int column = Column(point.x - radius); column <= Column(point.x + radius); ++column) {
      for (const int32_t i : cells[Cell(row, column)]) {
        const Segment& segment = segments[static_cast<size_t>(i)];
        const Point offset = point - segment.from;
        const double along = std::clamp(Dot(offset, segment.direction), 0.0, segment.span);
        const Point away = offset - along * segment.direction;
        const double squared = Dot(away, away);
        if (squared <= radius * radius) visit(segment, along, std::sqrt(squared));
      }
    }
  }
}

RoadMap::RoadMap(std::vector<Lane> lanes, std::vector<std::vector<Point>> junctions)
    : lanes_(std::move(lanes)), junctions_(std::move(junctions)) {
  auto grid = std::make_shared<Grid>();
  for (size_t i = 0; i < lanes_.size(); ++i) grid->AddLane(lanes_[i], static_cast<int>(i));
  grid->Bin();
  grid_ = std::move(grid);
}

int RoadMap::FindLane(const std::string& id) const {
  const auto found = grid_->lane_by_id.find(id);
  return found == grid_->lane_by_id.end() ? -1 : found->second;
}

std::optional<LanePosition> RoadMap::NearestLane(Point point, double heading, double radius) const {
  struct Candidate {
    const Grid::Segment* segment = nullptr;
    double along = 0.0;
    double distance = 0.0;
    double alignment = 0.0;  // cosine between the lane's direction and `heading`
  };
  Candidate best;
  const Point forward = Forward(heading);
  grid_->ForEachNear(point, radius, [&](const Grid::Segment& segment, double along, double distance) {
    const double alignment = Dot(segment.direction, forward);
    const bool nearer = best.segment == nullptr || distance < best.distance - kTie ||
                        (distance < best.distance + kTie && alignment > best.alignment + 1e-9);
    if (nearer) best = {&segment, along, distance, alignment};
  });
  if (best.segment == nullptr) return std::nullopt;
  const Grid::Segment& segment = *best.segment;
  const double side = Cross(segment.direction, point - segment.from);
  return LanePosition{segment.lane, segment.s + best.along, std::copysign(best.distance, side), best.distance,
                      std::atan2(segment.direction.y, segment.direction.x)};
}

bool RoadMap::OffRoad(Point point) const {
  bool on_road = false;
  grid_->ForEachNear(point, grid_->max_off_road_distance,
                     [&](const Grid::Segment& segment, double /*along*/, double distance) {
                       const double width = lanes_[static_cast<size_t>(segment.lane)].width;
                       on_road |= distance <= width / 2.0 + kOffRoadMargin;
                     });
  return !on_road;
}

}  // namespace dadrl
