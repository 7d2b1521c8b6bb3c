#include "common/step/step_spec_of.h"

#include "common/step/driving_shape.h"

namespace dadrl {

StepSpec StepSpecOf(const Config& config) { return DrivingStepSpec(config); }

}  // namespace dadrl
