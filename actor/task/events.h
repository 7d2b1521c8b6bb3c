// What happened to the ego in a step (SMARTS' event definitions; environment of the paper).
#pragma once

#include <vector>

#include "actor/sensing/localization.h"
#include "actor/sim/road_map.h"
#include "actor/sim/route.h"
#include "actor/sim/world_state.h"

namespace dadrl {

// The ego's centre this near to the goal has reached it.
constexpr double kGoalRadius = 2.0;

struct Events {
  bool collision = false;  // its box touches another
  bool off_road = false;   // its centre is off every lane
  bool goal = false;
  bool off_route = false;  // its nearest lane neither belongs to the route nor leads into it
  bool wrong_way = false;  // it faces against its nearest lane, outside junctions
};

// Borrows map and route. Immutable: any thread may use it.
class EventDetector {
 public:
  EventDetector(const RoadMap& map, const Route& route);

  Events Detect(const WorldState& world, const EgoLocation& location) const;

 private:
  bool WrongWay(const Pose& ego, const EgoLocation& location) const;
  bool OffRoute(const EgoLocation& location, bool wrong_way) const;
  // True when the lane runs against a lane of the route, right beside it: driving there is on the route, but
  // the wrong way.
  bool OncomingPartner(const LanePosition& position) const;

  const RoadMap& map_;
  const Route& route_;
  std::vector<bool> leads_to_route_;  // by lane: directly or through one junction
};

}  // namespace dadrl
