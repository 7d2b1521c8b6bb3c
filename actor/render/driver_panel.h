// What the driver does and gets, beside the scene.
#pragma once

#include "actor/render/film.h"

namespace dadrl {

// Time, lane command, speed and the speed asked for.
void DrawDriver(svg::Node parent, const Film& film, const svg::Box& box);

// The reward's terms: of the last step, and summed so far.
void DrawReward(svg::Node parent, const Film& film, const svg::Box& box, const char* title);

}  // namespace dadrl
