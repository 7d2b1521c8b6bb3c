// The two context planes: what is road, and where the ego should go (paper, section IV: context
// representation).
#pragma once

#include <cstdint>
#include <span>

#include "actor/sensing/drivable_area.h"
#include "actor/sim/geometry.h"
#include "actor/sim/road_map.h"
#include "actor/sim/route.h"
#include "common/step/driving_shape.h"

namespace dadrl {

// Side of the square that a plane shows, metres; the ego is its centre, its heading is up.
constexpr double kViewSide = 50.0;
constexpr double kPixelMetres = kViewSide / DrivingShape::kContextSize;
constexpr double kRouteHalfWidth = 1.0;
constexpr double kRouteAhead = 32.0;

// Each view is a rotated sample of the drivable area. Borrows map and route. Not thread safe; Draw allocates
// nothing but, in a large network, the surroundings of a place that is new.
class BirdsEyeView {
 public:
  BirdsEyeView(const RoadMap& map, const Route& route);

  // Overwrites `out` (DrivingShape::kContextBytes, the layout of DrivingShape): plane 0 the union
  // of lanes and junctions, to 0.2 m; plane 1 all points within 1 m of the route between `route_s` and
  // 32 m beyond. A pixel shows the point at its centre: pixel (row, column) is
  // 25 m - (row + 1/2) * 50/128 m ahead and 25 m - (column + 1/2) * 50/128 m to the left.
  void Draw(const Pose& ego, double route_s, std::span<uint8_t> out);

 private:
  void DrawDrivable(const Pose& ego, std::span<uint8_t> plane);
  void DrawRoute(const Pose& ego, double route_s, std::span<uint8_t> plane);

  const Route& route_;
  DrivableArea drivable_;
  BitGrid route_plane_;
};

}  // namespace dadrl
