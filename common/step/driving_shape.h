// What the ego sees and does: the columns that actor and networks agree on (paper, section IV).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "common/config/config.h"
#include "common/step/observation.h"

namespace dadrl {

// Sizes of the driving columns, and where they stand among an observation's; all follow from
// ObservationConfig.
//   vehicles [vehicles, history, 7] float32, scaled; x, y, heading in the ego's current frame; nearest
//   vehicle
//            first, history oldest first; an absent vehicle or row is {1, 0, 0, 0, 0, 0, 0}
//   ego      [history, 20] float32, scaled (actor/sensing/features.h)
//   context  [2, 128, 128] bits: drivable area, planned route; row 0 is 25 m ahead, column 0 is 25 m to the
//            left; pixel (plane, row, column) is bit (column % 8) of byte ((plane * 128 + row) * 16 + column
//            / 8)
//   polylines [2 (1 + vehicles), 10, 5] float32, scaled, where observation.polylines asks for them: two ways
//            ahead of the ego, then of each of `vehicles`, by points a metre apart; absent, x, y, cos, sin in
//            the ego's current frame; absent points are {1, 0, 0, 0, 0}
struct DrivingShape {
  static constexpr int kVehicleFeatures = 7;  // absent, x, y, cos, sin, speed, lane
  static constexpr int kEgoFeatures = 20;     // the same seven, then see actor/sensing
  static constexpr int kWays = 2;             // polylines of each
  static constexpr int kWayPoints = 10;
  static constexpr int kPointFeatures = 5;  // absent, x, y, cos, sin
  static constexpr int kContextPlanes = 2;
  static constexpr int kContextSize = kBitPlaneSide;  // pixels a side
  static constexpr int kContextBytes = kContextPlanes * kContextSize * kContextSize / 8;
  static constexpr float kFeatureBound = 5.0f;  // of every number of vehicles and ego, either side

  int vehicles = 6;
  int history = 5;
  bool polylines = false;
  size_t vehicles_column = 0;
  size_t ego_column = 1;
  size_t context_column = 2;
  size_t polylines_column = 3;  // where there are any

  // With the columns where DrivingStepSpec places them.
  static DrivingShape From(const ObservationConfig& config) {
    return {.vehicles = config.vehicles, .history = config.history, .polylines = config.polylines};
  }
  // The steps that hold these columns and an action alone: DrivingStepSpec.
  operator StepSpec() const;  // NOLINT(google-explicit-constructor): a shape stands for its steps
  // Of steps that may hold other columns too. kInvalidArgument lists them when a driving column is missing.
  static Result<DrivingShape> Find(const StepSpec& spec);

  int vehicle_floats() const { return vehicles * history * kVehicleFeatures; }
  int ego_floats() const { return history * kEgoFeatures; }
  int ways() const { return kWays * (1 + vehicles); }
  int polyline_floats() const { return polylines ? ways() * kWayPoints * kPointFeatures : 0; }
  bool operator==(const DrivingShape&) const = default;
};

// The policy's raw action, each in (-1, 1) (paper, section IV): element 0 is the target speed
// V_max (a0 + 1) / 2, element 1 the lane command: below -1/3 right, above 1/3 left, else keep.
constexpr int kActionSize = 2;
using Action = std::array<float, kActionSize>;

// The steps of a driving run, one line a column. The action is the first decision column.
StepSpec DrivingStepSpec(const DrivingShape& shape);
// With what the run records beside it.
StepSpec DrivingStepSpec(const Config& config);

}  // namespace dadrl
