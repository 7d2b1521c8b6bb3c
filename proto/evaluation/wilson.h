// Confidence of a measured rate.
#pragma once

#include <utility>

namespace dadrl {

// 95 % interval of a rate seen `hits` times in `trials` (Wilson score, 1927): honest near 0 and 1 and for few
// trials. {0, 1} when there was no trial.
std::pair<double, double> WilsonInterval(int hits, int trials);

}  // namespace dadrl
