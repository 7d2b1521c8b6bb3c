// What a run's steps hold, by its configuration: the one place that says what runs are about.
#pragma once

#include "common/config/config.h"
#include "common/step/step_spec.h"

namespace dadrl {

// Driving's columns. Whoever stores, moves or batches steps asks this, and knows columns alone.
StepSpec StepSpecOf(const Config& config);

}  // namespace dadrl
