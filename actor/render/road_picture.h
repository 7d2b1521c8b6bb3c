// The road network as a drawing, the same in every view.
#pragma once

#include "actor/render/svg.h"
#include "actor/sim/road_map.h"

namespace dadrl {

// Adds a group with the id "road" in metres (x east, y south): asphalt, edge lines, lane and centre lines,
// direction arrows. Views <use> it, scaled.
void DefineRoad(svg::Node defs, const RoadMap& map);

// The corners of the network.
struct Extent {
  Point low;
  Point high;
};
Extent ExtentOf(const RoadMap& map);

}  // namespace dadrl
