#include "actor/sim/scenario_rules.h"

#include <fmt/ranges.h>
#include <libsumo/libsumo.h>

#include <algorithm>
#include <utility>

#include "actor/sim/route.h"
#include "actor/sim/sumo_network.h"
#include "actor/sim/world_state.h"
#include "common/config/config_schema.h"

namespace dadrl {
namespace {

bool IsInNetwork(const std::vector<std::string>& ids, const std::string& id) {
  return std::ranges::find(ids, id) != ids.end();
}

// A fault of scenario.yaml, with its place.
template <typename... Args>
tl::unexpected<Error> Fault(const Scenario& scenario, int line, fmt::format_string<Args...> format,
                            Args&&... args) {
  return Fail(ErrorCode::kInvalidArgument, "{}:{}: {}", scenario.file.string(), line,
              fmt::format(format, std::forward<Args>(args)...));
}

std::string ListOf(const std::vector<std::string>& names) {
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

// SUMO takes the edges of a route as words, and ends a word at a space and at every byte that is not ASCII.
Status CheckWord(const Scenario& scenario, int line, const std::string& edge) {
  const bool is_word = std::ranges::all_of(edge, [](unsigned char c) { return c > ' ' && c < 0x7f; });
  if (is_word) return {};
  return Fault(
      scenario, line,
      "SUMO cannot read a route over edge '{}': its id has a space or a letter beyond ASCII; rename it "
      "in the network's plain XML",
      edge);
}

Status CheckLane(const Scenario& scenario, int line, const std::string& edge, int lane,
                 const std::string& vehicle_class) {
  const int lanes = libsumo::Edge::getLaneNumber(edge);
  if (lane >= lanes) {
    return Fault(scenario, line, "traffic.flows: edge '{}' has no lane {}; its lanes are 0 to {}", edge, lane,
                 lanes - 1);
  }
  const std::vector<int> open = OpenLanes(edge, vehicle_class);
  if (std::ranges::find(open, lane) != open.end()) return {};
  return Fault(scenario, line, "traffic.flows: lane {} of edge '{}' is closed to vClass {}; open to it: {}",
               lane, edge, vehicle_class, open.empty() ? "none" : fmt::format("{}", fmt::join(open, ", ")));
}

// The edges that `edge` leads into, for vehicles of `vehicle_class`.
std::vector<std::string> EdgesBehind(const std::string& edge, const std::string& vehicle_class) {
  std::vector<std::string> behind;
  for (const int lane : OpenLanes(edge, vehicle_class)) {
    for (const libsumo::TraCIConnection& link : libsumo::Lane::getLinks(LaneId(edge, lane))) {
      const std::string next = libsumo::Lane::getEdgeID(link.approachedLane);
      if (LaneAllows(link.approachedLane, vehicle_class) && !IsInNetwork(behind, next))
        behind.push_back(next);
    }
  }
  return behind;
}

// The map has only what is open to cars: tells a closed lane from one that is not there.
Status CheckEgoLanes(const Scenario& scenario, const RoadMap& map) {
  std::vector<std::string> open;
  for (const Lane& lane : map.lanes()) {
    if (!lane.internal) open.push_back(lane.id);
  }
  const std::vector<std::string> all = libsumo::Lane::getIDList();
  for (const std::string& id : scenario.ego_lanes) {
    if (IsInNetwork(open, id)) continue;
    if (map.FindLane(id) >= 0) {
      return Fault(
          scenario, scenario.ego_line,
          "ego.lanes: '{}' is inside a junction; leave it out, the lanes before and behind it say the "
          "way",
          id);
    }
    if (IsInNetwork(all, id)) {
      return Fault(scenario, scenario.ego_line, "ego.lanes: lane '{}' is closed to cars", id);
    }
    return Fault(scenario, scenario.ego_line,
                 "ego.lanes: lane '{}' is not in the network; the nearest is '{}'", id,
                 NearestName(id, open));
  }
  return {};
}

// Networks built without lanes inside junctions leave holes in the way.
Status CheckJunctionLanes(const Scenario& scenario, const RoadMap& map, const std::vector<int>& lanes) {
  constexpr double kHole = 0.5;
  for (size_t i = 0; i + 1 < lanes.size(); ++i) {
    const Lane& lane = map.lane(lanes[i]);
    const Lane& next = map.lane(lanes[i + 1]);
    if (lane.edge == next.edge) continue;
    const double hole = Norm(next.centre.points().front() - lane.centre.points().back());
    if (hole < kHole) continue;
    return Fail(ErrorCode::kInvalidArgument,
                "{}: between lanes '{}' and '{}' there are {:.1f} m without a lane; build the network with "
                "lanes inside its junctions (netconvert without --no-internal-links)",
                scenario.network.string(), lane.id, next.id, hole);
  }
  return {};
}

}  // namespace

std::string LaneId(const std::string& edge, int lane) { return fmt::format("{}_{}", edge, lane); }

std::vector<int> OpenLanes(const std::string& edge, const std::string& vehicle_class) {
  std::vector<int> lanes;
  for (int lane = 0; lane < libsumo::Edge::getLaneNumber(edge); ++lane) {
    if (LaneAllows(LaneId(edge, lane), vehicle_class)) lanes.push_back(lane);
  }
  return lanes;
}

Result<std::vector<int>> EgoLanes(const Scenario& scenario, const RoadMap& map) {
  DADRL_RETURN_IF_ERROR(CheckEgoLanes(scenario, map));
  auto lanes = ConnectLanes(map, scenario.ego_lanes);
  if (!lanes) return Fault(scenario, scenario.ego_line, "ego.lanes: {}", lanes.error().message);
  for (const int lane : *lanes) {
    DADRL_RETURN_IF_ERROR(CheckWord(scenario, scenario.ego_line, map.lane(lane).edge));
  }
  DADRL_RETURN_IF_ERROR(CheckJunctionLanes(scenario, map, *lanes));
  const Lane& first = map.lane(lanes->front());
  const double length = first.centre.length();
  if (scenario.ego_start_offset_m > length) {
    return Fault(scenario, scenario.ego_line, "ego.start_offset_m: {} exceeds lane '{}' of {:.2f} m",
                 scenario.ego_start_offset_m, first.id, length);
  }
  if (lanes->size() == 1 && length - scenario.ego_start_offset_m < kVehicleLength) {
    return Fault(scenario, scenario.ego_line,
                 "ego.start_offset_m: {} leaves {:.2f} m to drive, less than a car's length; lane '{}' has "
                 "{:.2f} m",
                 scenario.ego_start_offset_m, length - scenario.ego_start_offset_m, first.id, length);
  }
  return lanes;
}

Status CheckFlow(const Scenario& scenario, const TrafficFlow& flow, const std::vector<std::string>& edges,
                 const std::string& vehicle_class) {
  for (const std::string& edge : flow.edges) {
    DADRL_RETURN_IF_ERROR(CheckWord(scenario, flow.line, edge));
    if (IsInNetwork(edges, edge)) continue;
    return Fault(scenario, flow.line, "traffic.flows: edge '{}' is not in the network; the nearest is '{}'",
                 edge, NearestName(edge, edges));
  }
  DADRL_RETURN_IF_ERROR(CheckLane(scenario, flow.line, flow.edges.front(), flow.depart_lane, vehicle_class));
  for (size_t i = 0; i + 1 < flow.edges.size(); ++i) {
    const std::vector<std::string> behind = EdgesBehind(flow.edges[i], vehicle_class);
    if (IsInNetwork(behind, flow.edges[i + 1])) continue;
    return Fault(scenario, flow.line,
                 "traffic.flows: edge '{}' does not lead into '{}' for vClass {}; it leads into: {}",
                 flow.edges[i], flow.edges[i + 1], vehicle_class, ListOf(behind));
  }
  return CheckLane(scenario, flow.line, flow.edges.back(), flow.arrival_lane, vehicle_class);
}

}  // namespace dadrl
