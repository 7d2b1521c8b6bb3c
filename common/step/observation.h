// One observation, as whoever acts sees it.
#pragma once

#include "common/step/columns.h"

namespace dadrl {

class Observation : public Columns {
 public:
  explicit Observation(const StepSpec& spec) : Columns(spec, 1) {}
};

}  // namespace dadrl
