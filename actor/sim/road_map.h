// The road network as geometry: lanes, junction areas, and the questions the task asks of them. No simulator
// inside.
#pragma once

#include <memory>
#include <optional>
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
  double s = 0.0;         // along the centre line
  double lateral = 0.0;   // from the centre line, left positive
  double distance = 0.0;  // to the centre line
  double heading = 0.0;   // of the lane there
};

// Immutable after construction; any thread may read it.
class RoadMap {
 public:
  RoadMap(std::vector<Lane> lanes, std::vector<std::vector<Point>> junctions);

  const std::vector<Lane>& lanes() const { return lanes_; }
  // Polygons of the junction areas, without closing point.
  const std::vector<std::vector<Point>>& junctions() const { return junctions_; }
  // -1 when there is none.
  int FindLane(const std::string& id) const;

  // The lane whose centre line is nearest within `radius`; nothing when there is none. Ties go to the lane
  // whose direction is nearest `heading`.
  std::optional<LanePosition> NearestLane(Point point, double heading, double radius) const;
  // True when the point is farther than half a lane width + 0.1 m from every centre line (environment:
  // off-road).
  bool OffRoad(Point point) const;

 private:
  std::vector<Lane> lanes_;
  std::vector<std::vector<Point>> junctions_;
  // Uniform grid over the network: each cell lists the lane segments near it.
  struct Grid;
  std::shared_ptr<const Grid> grid_;  // shared by copies of the map: it never changes
};

}  // namespace dadrl
