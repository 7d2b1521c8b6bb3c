// Density and speed of the traffic over fixed seeds, against what was measured for the published scenarios.
#include <gtest/gtest.h>

#include "actor/sim/simulation.h"

namespace dadrl {
namespace {}  // namespace
}  // namespace dadrl
