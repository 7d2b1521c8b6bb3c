#include "actor/sim/sumo_network.h"

#include <libsumo/libsumo.h>

#include <unordered_map>

namespace dadrl {
namespace {

std::vector<Point> ToPoints(const libsumo::TraCIPositionVector& shape) {
  std::vector<Point> points;
  points.reserve(shape.value.size());
  for (const libsumo::TraCIPosition& position : shape.value) points.push_back({position.x, position.y});
  return points;
}

}  // namespace

RoadMap ReadSumoNetwork() {
  const std::vector<std::string> ids = libsumo::Lane::getIDList();
  std::unordered_map<std::string, int> index;
  for (size_t i = 0; i < ids.size(); ++i) index.emplace(ids[i], static_cast<int>(i));

  std::vector<Lane> lanes;
  lanes.reserve(ids.size());
  for (const std::string& id : ids) {
    Lane lane;
    lane.id = id;
    lane.edge = libsumo::Lane::getEdgeID(id);
    lane.index = std::stoi(id.substr(id.rfind('_') + 1));
    lane.internal = id.front() == ':';
    lane.width = libsumo::Lane::getWidth(id);
    lane.speed_limit = libsumo::Lane::getMaxSpeed(id);
    lane.centre = Polyline(ToPoints(libsumo::Lane::getShape(id)));
    for (const libsumo::TraCIConnection& link : libsumo::Lane::getLinks(id)) {
      const std::string& next =
          link.approachedInternal.empty() ? link.approachedLane : link.approachedInternal;
      lane.successors.push_back(index.at(next));
    }
    lanes.push_back(std::move(lane));
  }

  std::vector<std::vector<Point>> junctions;
  for (const std::string& id : libsumo::Junction::getIDList()) {
    std::vector<Point> outline = ToPoints(libsumo::Junction::getShape(id));
    // Waiting points inside a junction and the ends of dead ends have no area.
    if (id.front() == ':' || outline.size() < 3) continue;
    const bool closed = Norm(outline.front() - outline.back()) < 1e-6;
    if (closed) outline.pop_back();
    if (outline.size() >= 3) junctions.push_back(std::move(outline));
  }
  return RoadMap(std::move(lanes), std::move(junctions));
}

}  // namespace dadrl
