// The road network as geometry: lanes, junction areas, and the questions the task asks of them. No simulator
// inside.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "actor/sim/geometry.h"
#include "actor/sim/polyline.h"

namespace dadrl {

struct Lane {
  std::string id;         // SUMO's, e.g. "south-SN_1" or ":J_2_0"
  std::string edge;       // SUMO's edge id
  int index = 0;          // 0 is the rightmost
  bool internal = false;  // inside a junction
  double width = 3.2;
  double speed_limit = 0.0;     // m/s
  Polyline centre;              // geometric, in driving direction
  std::vector<int> successors;  // lanes it leads into, through internal lanes (each an index of its own)
};

// Where a point is relative to a lane.
struct LanePosition {
  int lane = -1;
  double s = 0.0;          // along the centre line
  double lateral = 0.0;    // from the centre line, left positive
  double distance = 0.0;   // to the centre line
  double heading = 0.0;    // of the lane there
  double elevation = 0.0;  // of the lane there, metres
};

// Immutable after construction; any thread may read it.
class RoadMap {
 public:
  RoadMap(std::vector<Lane> lanes, std::vector<std::vector<Point>> junctions);

  const std::vector<Lane>& lanes() const { return lanes_; }
  const Lane& lane(int index) const { return lanes_[static_cast<size_t>(index)]; }
  // Polygons of the junction areas, without closing point.
  const std::vector<std::vector<Point>>& junctions() const { return junctions_; }
  // -1 when there is none.
  int FindLane(const std::string& id) const;
  // Of an edge, from right to left; empty when there is no such edge.
  std::span<const int> LanesOfEdge(const std::string& edge) const;
  // Every way from the end of `lane` through the junction there, if there is one: the lanes inside it in
  // order, and last the first lane behind it.
  std::vector<std::vector<int>> CrossingsFrom(int lane) const;

  // False when the whole network is at height 0: elevations do not matter then.
  bool has_levels() const { return has_levels_; }

  // The lane whose centre line is nearest within `radius`, of those on the level of `elevation` (OnOneLevel);
  // nothing when there is none. Ties go to the lane whose direction is nearest `heading`.
  std::optional<LanePosition> NearestLane(Point point, double heading, double radius,
                                          double elevation = 0.0) const;
  // True when the point is farther than half a lane width + 0.1 m from every centre line of its level
  // (environment: off-road).
  bool OffRoad(Point point, double elevation = 0.0) const;

 private:
  std::vector<Lane> lanes_;
  std::vector<std::vector<Point>> junctions_;
  bool has_levels_ = false;
  struct Index;
  std::shared_ptr<const Index> index_;  // shared by copies of the map: it never changes
};

}  // namespace dadrl
