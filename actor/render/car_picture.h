// Vehicles from above.
#pragma once

#include "actor/render/film.h"
#include "actor/render/vehicle_visits.h"

namespace dadrl {

struct CarStyle {
  svg::Scale scale;
  bool names = true;             // the car's number on it
  double attention_shown = 0.0;  // less is not written beside the car
};

// In world coordinates, for as long as the visit lasts; more orange the more attention it gets. The car that
// the ego hit is marked on the episode's last moment.
void DrawCar(svg::Node parent, const Film& film, const VehicleVisit& visit, const CarStyle& style);

// Its attention in per cent, above where DrawCar draws it.
void DrawWeight(svg::Node parent, const Film& film, const VehicleVisit& visit, const CarStyle& style);

// Turning at `at`.
void DrawEgo(svg::Node parent, const Film& film, Point at, const svg::Scale& scale);

}  // namespace dadrl
