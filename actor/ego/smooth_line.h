// Rounds the corners of a road's polygon, so that following it does not shake the steering.
#pragma once

#include <vector>

#include "actor/sim/polyline.h"

namespace dadrl {

// A centripetal Catmull-Rom curve (Yuksel et al., 2011) through the points, sampled about every half metre.
// It passes through every point; long straights stay straight except near their ends.
Polyline SmoothLine(const Polyline& line);

}  // namespace dadrl
