// Pause and winding for an animated picture that is opened by itself.
#pragma once

#include "actor/render/svg.h"

namespace dadrl {

// Where scripts are not run (a picture within a page) nothing is lost but this.
void AddPlayer(svg::Node root, double duration_s);

}  // namespace dadrl
