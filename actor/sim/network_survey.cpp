#include "actor/sim/network_survey.h"

#include <libsumo/libsumo.h>

#include <algorithm>
#include <cmath>

#include "actor/sim/sumo_network.h"
#include "actor/sim/world_state.h"

namespace dadrl {
namespace {

// Lanes of one road share a length; on the inside of a bend it is more than what is drawn.
constexpr double kStretch = 0.2;
constexpr double kStretchMetres = 5.0;

std::string KindOf(const std::string& lane) {
  const std::vector<std::string> allowed = libsumo::Lane::getAllowed(lane);
  const auto allows = [&](const char* vehicle_class) {
    return std::find(allowed.begin(), allowed.end(), vehicle_class) != allowed.end();
  };
  if (allows("bus")) return "bus lane";
  if (allows("bicycle")) return "cycle lane";
  if (allows("tram") || allows("rail") || allows("rail_urban") || allows("rail_electric")) return "rail";
  if (allows("pedestrian")) return lane.front() == ':' ? "crossing" : "pavement";
  return "other lane";
}

double DrawnLength(const std::string& lane) {
  const auto shape = libsumo::Lane::getShape(lane);
  double length = 0.0;
  for (size_t i = 0; i + 1 < shape.value.size(); ++i) {
    const libsumo::TraCIPosition& a = shape.value[i];
    const libsumo::TraCIPosition& b = shape.value[i + 1];
    length += std::hypot(b.x - a.x, b.y - a.y, b.z - a.z);
  }
  return length;
}

bool IsStretched(const std::string& lane) {
  const double drawn = DrawnLength(lane);
  const double difference = std::abs(libsumo::Lane::getLength(lane) - drawn);
  return difference > kStretchMetres && difference > kStretch * drawn;
}

}  // namespace

NetworkSurvey SurveySumoNetwork() {
  NetworkSurvey survey;
  survey.traffic_lights = static_cast<int>(libsumo::TrafficLight::getIDList().size());
  for (const std::string& id : libsumo::Junction::getIDList()) survey.junctions += id.front() != ':' ? 1 : 0;
  for (const std::string& id : libsumo::Edge::getIDList()) survey.roads += id.front() != ':' ? 1 : 0;
  for (const std::string& id : libsumo::Lane::getIDList()) {
    const bool inside = id.front() == ':';
    if (!LaneAllows(id, kCarClass)) {
      const std::string kind = KindOf(id);
      // Of the lanes that cross a junction only zebras are something to see.
      if (!inside || kind == "crossing") ++survey.ignored[kind];
      continue;
    }
    if (inside) continue;
    ++survey.car_lanes;
    if (IsStretched(id)) survey.stretched.push_back(id);
  }
  return survey;
}

}  // namespace dadrl
