#include "actor/render/vehicle_visits.h"

#include <map>

namespace dadrl {
namespace {

double AttentionOf(const Moment& moment, int vehicle) {
  for (const Attention& attention : moment.attention) {
    if (attention.vehicle == vehicle) return attention.weight;
  }
  return 0.0;
}

bool Continues(const VehicleVisit& visit, size_t moment, const SocialVehicle& vehicle) {
  return visit.first + visit.poses.size() == moment && visit.trip == vehicle.trip;
}

}  // namespace

std::vector<VehicleVisit> FindVisits(const Film& film) {
  std::map<int, std::vector<VehicleVisit>> by_vehicle;
  for (size_t i = 0; i < film.size(); ++i) {
    for (const SocialVehicle& vehicle : film[i].world.vehicles) {
      std::vector<VehicleVisit>& visits = by_vehicle[vehicle.id];
      if (visits.empty() || !Continues(visits.back(), i, vehicle)) {
        visits.push_back({.vehicle = vehicle.id,
                          .trip = vehicle.trip,
                          .length_m = vehicle.length_m,
                          .width_m = vehicle.width_m,
                          .first = i,
                          .poses = {},
                          .weights = {}});
      }
      visits.back().poses.push_back(vehicle.pose);
      visits.back().weights.push_back(AttentionOf(film[i], vehicle.id));
    }
  }
  std::vector<VehicleVisit> ordered;
  for (auto& [vehicle, visits] : by_vehicle) {
    ordered.insert(ordered.end(), std::make_move_iterator(visits.begin()),
                   std::make_move_iterator(visits.end()));
  }
  return ordered;
}

}  // namespace dadrl
