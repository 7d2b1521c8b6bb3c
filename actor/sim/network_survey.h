// What a network has beside the lanes that the map keeps.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace dadrl {

struct NetworkSurvey {
  int roads = 0;  // SUMO's edges, those inside junctions left out
  int junctions = 0;
  int traffic_lights = 0;
  int car_lanes = 0;  // outside junctions
  // Lanes that are no road for the ego, by kind: "pavement", "crossing", "cycle lane", "bus lane", "rail",
  // "other lane".
  std::map<std::string, int> ignored;
  // Car lanes whose length in SUMO, which speeds and gaps go by, is not the one that is drawn.
  std::vector<std::string> stretched;
};

// Of the network that libsumo has loaded. Throws what libsumo throws.
NetworkSurvey SurveySumoNetwork();

}  // namespace dadrl
