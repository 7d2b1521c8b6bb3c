// What the ego sees and does: the tensors that actor, replay codec and learner agree on (design, section 4).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/config/config.h"

namespace dadrl {

// Sizes of one observation; follow from ObservationConfig everywhere.
struct ObservationSpec {
  static constexpr int kVehicleFeatures = 7;  // absent, x, y, cos, sin, speed, lane
  static constexpr int kEgoFeatures = 20;     // the same seven, then see actor/sensing
  static constexpr int kContextPlanes = 2;    // drivable area, planned route
  static constexpr int kContextSize = 128;    // pixels a side
  static constexpr int kContextBytes = kContextPlanes * kContextSize * kContextSize / 8;
  static constexpr float kFeatureBound = 5.0f;  // of every number of vehicles and ego, either side

  int vehicles = 6;
  int history = 5;

  static ObservationSpec From(const ObservationConfig& config) { return {config.vehicles, config.history}; }
  int vehicle_floats() const { return vehicles * history * kVehicleFeatures; }
  int ego_floats() const { return history * kEgoFeatures; }
  bool operator==(const ObservationSpec&) const = default;
};

// One observation, owned.
struct Observation {
  // [vehicles, history, 7] float32, scaled; x, y, heading in the ego's current frame; nearest vehicle first,
  // history oldest first; an absent vehicle or row is {1, 0, 0, 0, 0, 0, 0}.
  std::vector<float> vehicles;
  // [history, 20] float32, scaled.
  std::vector<float> ego;
  // [2, 128, 128] bits, row-major; row 0 is 25 m ahead, column 0 is 25 m to the left.
  // Pixel (plane, row, column) is bit (column % 8) of byte ((plane * 128 + row) * 16 + column / 8).
  std::vector<uint8_t> context;

  explicit Observation(const ObservationSpec& spec)
      : vehicles(static_cast<size_t>(spec.vehicle_floats())),
        ego(static_cast<size_t>(spec.ego_floats())),
        context(ObservationSpec::kContextBytes) {}
  bool operator==(const Observation&) const = default;
};

// A batch of observations: the same arrays with the batch index in front.
struct ObservationBatch {
  int size = 0;
  std::vector<float> vehicles;   // [size, vehicles, history, 7]
  std::vector<float> ego;        // [size, history, 20]
  std::vector<uint8_t> context;  // [size, 4096]

  ObservationBatch(const ObservationSpec& spec, int batch_size)
      : size(batch_size),
        vehicles(static_cast<size_t>(batch_size * spec.vehicle_floats())),
        ego(static_cast<size_t>(batch_size * spec.ego_floats())),
        context(static_cast<size_t>(batch_size) * ObservationSpec::kContextBytes) {}
};

// The policy's raw action, each in (-1, 1) (paper, section IV): element 0 is the target speed
// V_max (a0 + 1) / 2, element 1 the lane command: below -1/3 right, above 1/3 left, else keep.
constexpr int kActionSize = 2;
using Action = std::array<float, kActionSize>;

}  // namespace dadrl
