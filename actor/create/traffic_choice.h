// Which traffic an ego's way needs, where nobody has counted any.
#pragma once

#include <string>
#include <vector>

#include "actor/sim/road_map.h"
#include "actor/sim/scenario.h"

namespace dadrl {

struct TrafficChoice {
  std::vector<TrafficFlow> flows;
  int driver_types = 1;  // vehicles of each flow
};

// A guess, not a count. Flows: from each street that leads into a junction of the route, through it by each
// of its exits, straight on for 100 m before and behind; the first 12, junction by junction, none that
// departs where the ego starts. As many vehicles as give one to 30 m of their lanes, 1 to 8 a flow.
TrafficChoice ChooseTraffic(const RoadMap& map, const std::vector<std::string>& route_lanes);

}  // namespace dadrl
