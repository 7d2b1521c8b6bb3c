#include "actor/sim/road_map.h"

#include <algorithm>
#include <unordered_map>

#include "actor/sim/lane_grid.h"

namespace dadrl {
namespace {

// Centre lines nearer to each other than this count as equally near: lanes that fork run on top of each
// other.
constexpr double kTie = 0.01;
constexpr double kOffRoadMargin = 0.1;

using Way = std::vector<int>;

// Extends `way`, which has come to the end of `lane`; each complete one goes to `ways`.
void FindCrossings(const std::vector<Lane>& lanes, int lane, Way& way, std::vector<Way>& ways) {
  for (const int next : lanes[static_cast<size_t>(lane)].successors) {
    // Lanes that a junction leads round in a circle.
    if (std::ranges::find(way, next) != way.end()) continue;
    way.push_back(next);
    if (lanes[static_cast<size_t>(next)].internal) {
      FindCrossings(lanes, next, way, ways);
    } else {
      ways.push_back(way);
    }
    way.pop_back();
  }
}

}  // namespace

struct RoadMap::Index {
  LaneGrid grid;
  std::unordered_map<std::string, int> lane_by_id;
  std::unordered_map<std::string, std::vector<int>> lanes_by_edge;
  double max_off_road_distance = 0.0;
};

RoadMap::RoadMap(std::vector<Lane> lanes, std::vector<std::vector<Point>> junctions)
    : lanes_(std::move(lanes)), junctions_(std::move(junctions)) {
  auto index = std::make_shared<Index>();
  for (size_t i = 0; i < lanes_.size(); ++i) {
    index->grid.Add(lanes_[i].centre, i);
    index->lane_by_id.emplace(lanes_[i].id, i);
    index->lanes_by_edge[lanes_[i].edge].push_back(i);
    index->max_off_road_distance =
        std::max(index->max_off_road_distance, lanes_[i].width / 2.0 + kOffRoadMargin);
  }
  has_levels_ = std::ranges::any_of(index->grid.segments(), [](const LaneGrid::Segment& segment) {
    return segment.elevation != 0.0 || segment.slope != 0.0;
  });
  index->grid.Bin();
  index_ = std::move(index);
}

int RoadMap::FindLane(const std::string& id) const {
  const auto found = index_->lane_by_id.find(id);
  return found == index_->lane_by_id.end() ? -1 : found->second;
}

std::span<const int> RoadMap::LanesOfEdge(const std::string& edge) const {
  const auto found = index_->lanes_by_edge.find(edge);
  return found == index_->lanes_by_edge.end() ? std::span<const int>() : found->second;
}

std::vector<std::vector<int>> RoadMap::CrossingsFrom(int lane) const {
  std::vector<Way> ways;
  Way way;
  FindCrossings(lanes_, lane, way, ways);
  return ways;
}

std::optional<LanePosition> RoadMap::NearestLane(Point point, double heading, double radius,
                                                 double elevation) const {
  struct Candidate {
    const LaneGrid::Segment* segment = nullptr;
    double along = 0.0;
    double distance = 0.0;
    double alignment = 0.0;  // cosine between the lane's direction and `heading`
  };
  Candidate best;
  const Point forward = Forward(heading);
  index_->grid.ForEachNear(
      point, radius, [&](const LaneGrid::Segment& segment, double along, double distance) {
        if (!OnOneLevel(segment.ElevationAt(along) - elevation, distance)) return;
        const double alignment = Dot(segment.direction, forward);
        const bool nearer = best.segment == nullptr || distance < best.distance - kTie ||
                            (distance < best.distance + kTie && alignment > best.alignment + 1e-9);
        if (nearer) best = {&segment, along, distance, alignment};
      });
  if (best.segment == nullptr) return std::nullopt;
  const LaneGrid::Segment& segment = *best.segment;
  const double side = Cross(segment.direction, point - segment.from);
  return LanePosition{segment.lane,
                      segment.s + best.along,
                      std::copysign(best.distance, side),
                      best.distance,
                      std::atan2(segment.direction.y, segment.direction.x),
                      segment.ElevationAt(best.along)};
}

bool RoadMap::OffRoad(Point point, double elevation) const {
  bool on_road = false;
  index_->grid.ForEachNear(point, index_->max_off_road_distance,
                           [&](const LaneGrid::Segment& segment, double along, double distance) {
                             if (!OnOneLevel(segment.ElevationAt(along) - elevation, distance)) return;
                             const double width = lanes_[static_cast<size_t>(segment.lane)].width;
                             on_road |= distance <= width / 2.0 + kOffRoadMargin;
                           });
  return !on_road;
}

}  // namespace dadrl
