// Who is in the picture when.
#pragma once

#include <vector>

#include "actor/render/film.h"

namespace dadrl {

// One vehicle from when it comes into the network until it leaves it. A car that loops has several.
struct VehicleVisit {
  int vehicle = 0;  // SocialVehicle::id
  int trip = 0;     // SocialVehicle::trip
  double length_m = 0.0;
  double width_m = 0.0;
  size_t first = 0;             // moment of the film
  std::vector<Pose> poses;      // at moments first, first + 1, ...
  std::vector<double> weights;  // attention at these moments; 0 without
  bool Includes(size_t moment) const { return moment >= first && moment < first + poses.size(); }
};

// Ordered by vehicle, then by time.
std::vector<VehicleVisit> FindVisits(const Film& film);

}  // namespace dadrl
