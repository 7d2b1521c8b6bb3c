#include "actor/create/traffic_choice.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <utility>

namespace dadrl {
namespace {

constexpr double kApproachMetres = 100.0;
constexpr size_t kMostFlows = 12;
constexpr double kMetresPerVehicle = 30.0;
constexpr int kMostTypes = 8;
// A turn sharper than this leads back where one came from.
constexpr double kUTurn = 0.85 * std::numbers::pi;

using Edges = std::vector<std::string>;

// The network as edges that lead into edges.
class EdgeGraph {
 public:
  explicit EdgeGraph(const RoadMap& map) : map_(map) {}

  const Edges& Behind(const std::string& edge) {
    const auto [found, is_new] = behind_.try_emplace(edge);
    if (is_new) {
      for (const int lane : map_.LanesOfEdge(edge)) {
        for (const std::vector<int>& way : map_.CrossingsFrom(lane)) {
          const std::string& next = map_.lane(way.back()).edge;
          if (!Contains(found->second, next) && Turn(edge, next) < kUTurn) found->second.push_back(next);
        }
      }
    }
    return found->second;
  }

  const Edges& Before(const std::string& edge) {
    if (before_.empty()) {
      for (const Lane& lane : map_.lanes()) {
        if (lane.internal) continue;
        for (const std::string& next : Behind(lane.edge)) {
          if (!Contains(before_[next], lane.edge)) before_[next].push_back(lane.edge);
        }
      }
    }
    return before_[edge];
  }

  double Length(const std::string& edge) const { return Rightmost(edge).centre.length(); }
  const Lane& Rightmost(const std::string& edge) const { return map_.lane(map_.LanesOfEdge(edge).front()); }
  size_t LaneCount(const std::string& edge) const { return map_.LanesOfEdge(edge).size(); }

  // How far one turns from the end of `edge` into `next`, radians.
  double Turn(const std::string& edge, const std::string& next) const {
    const Polyline& centre = Rightmost(edge).centre;
    return std::abs(WrapAngle(Rightmost(next).centre.HeadingAt(0.0) - centre.HeadingAt(centre.length())));
  }

  static bool Contains(const Edges& edges, const std::string& edge) {
    return std::ranges::find(edges, edge) != edges.end();
  }

 private:
  const RoadMap& map_;
  std::map<std::string, Edges> behind_;
  std::map<std::string, Edges> before_;
};

// The edges that lead into the junction at the end of `edge`: those that share an exit, and theirs.
Edges IntoJunctionBehind(EdgeGraph& graph, const std::string& edge) {
  Edges into{edge};
  for (size_t i = 0; i < into.size(); ++i) {
    for (const std::string& exit : Edges(graph.Behind(into[i]))) {
      for (const std::string& other : graph.Before(exit)) {
        if (!EdgeGraph::Contains(into, other)) into.push_back(other);
      }
    }
  }
  return into;
}

// Straight on, until it is long enough; `next(edge)` are the ways on, `turn` how sharp each is.
template <typename Next, typename Turn>
Edges Straight(const EdgeGraph& graph, const std::string& from, Next next, Turn turn) {
  Edges way{from};
  double metres = graph.Length(from);
  while (metres < kApproachMetres) {
    Edges on = next(way.back());
    std::erase_if(on, [&](const std::string& edge) { return EdgeGraph::Contains(way, edge); });
    if (on.empty()) break;
    way.push_back(
        *std::ranges::min_element(on, {}, [&](const std::string& edge) { return turn(way.back(), edge); }));
    metres += graph.Length(way.back());
  }
  return way;
}

// From `into` over the junction into `exit`, with what leads there and what follows; empty where that would
// be a ring.
Edges FlowThrough(EdgeGraph& graph, const std::string& into, const std::string& exit) {
  Edges flow = Straight(
      graph, into, [&](const std::string& edge) { return graph.Before(edge); },
      [&](const std::string& edge, const std::string& before) { return graph.Turn(before, edge); });
  std::ranges::reverse(flow);
  const Edges behind = Straight(
      graph, exit, [&](const std::string& edge) { return graph.Behind(edge); },
      [&](const std::string& edge, const std::string& next) { return graph.Turn(edge, next); });
  for (const std::string& edge : behind) {
    if (EdgeGraph::Contains(flow, edge)) return {};
    flow.push_back(edge);
  }
  return flow;
}

Edges EdgesOf(const RoadMap& map, const std::vector<std::string>& lanes) {
  Edges edges;
  for (const std::string& id : lanes) {
    const std::string& edge = map.lane(map.FindLane(id)).edge;
    if (edges.empty() || edges.back() != edge) edges.push_back(edge);
  }
  return edges;
}

std::vector<Edges> FlowsAlong(EdgeGraph& graph, const Edges& route) {
  std::vector<Edges> flows;
  for (const std::string& edge : route) {
    for (const std::string& into : IntoJunctionBehind(graph, edge)) {
      for (const std::string& exit : Edges(graph.Behind(into))) {
        const Edges flow = FlowThrough(graph, into, exit);
        if (flow.empty() || flow.front() == route.front()) continue;
        if (std::ranges::find(flows, flow) == flows.end()) flows.push_back(flow);
        if (flows.size() == kMostFlows) return flows;
      }
    }
  }
  return flows;
}

}  // namespace

TrafficChoice ChooseTraffic(const RoadMap& map, const std::vector<std::string>& route_lanes) {
  EdgeGraph graph(map);
  TrafficChoice choice;
  std::set<std::string> used;
  double lane_metres = 0.0;
  for (const Edges& edges : FlowsAlong(graph, EdgesOf(map, route_lanes))) {
    for (const std::string& edge : edges) {
      if (!used.insert(edge).second) continue;
      lane_metres += graph.Length(edge) * static_cast<double>(graph.LaneCount(edge));
    }
    choice.flows.push_back({.edges = edges,
                            .depart_lane = graph.Rightmost(edges.front()).index,
                            .arrival_lane = graph.Rightmost(edges.back()).index,
                            .depart = FlowPosition::kRandom,
                            .arrival = FlowPosition::kLaneEnd});
  }
  if (choice.flows.empty()) return choice;
  const double vehicles = lane_metres / kMetresPerVehicle;
  choice.driver_types = std::clamp(
      static_cast<int>(std::lround(vehicles / static_cast<double>(choice.flows.size()))), 1, kMostTypes);
  return choice;
}

}  // namespace dadrl
