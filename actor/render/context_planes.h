// The two bird's-eye planes of the observation, as the policy gets them.
#pragma once

#include "actor/render/film.h"

namespace dadrl {

// Side by side, each a square as wide as fits, with what it is below.
void DrawPlanes(svg::Node parent, const Film& film, const svg::Box& box);
// One below the other.
void DrawPlanesStacked(svg::Node parent, const Film& film, const svg::Box& box);

}  // namespace dadrl
