// The scene from above, north up, the ego in the middle.
#pragma once

#include "actor/render/film.h"
#include "actor/render/svg.h"

namespace dadrl {

struct WorldView {
  svg::Box box;
  double pixels_per_metre = 8.0;
  bool names = true;  // writes each car's number on it
};

// Road (DefineRoad's), route and goal, where the ego came from, all cars, the attention each gets, and on the
// last moment of the episode what ended it.
void DrawWorld(svg::Node parent, const Film& film, const WorldView& view);

// The whole network with route, goal and the ego's place.
void DrawOverview(svg::Node parent, const Film& film, const svg::Box& box);

}  // namespace dadrl
