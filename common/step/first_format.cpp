#include "common/step/first_format.h"

#include <array>

#include "common/io/checksum.h"
#include "common/step/driving_shape.h"

namespace dadrl {
namespace {

// The sizes went into the hash behind the format's version, 1.
uint64_t Hash(const DrivingShape& shape) {
  const std::array<int, 8> values = {1,
                                     shape.vehicles,
                                     shape.history,
                                     DrivingShape::kVehicleFeatures,
                                     DrivingShape::kEgoFeatures,
                                     DrivingShape::kContextPlanes,
                                     DrivingShape::kContextSize,
                                     kActionSize};
  return Xxh3(std::as_bytes(std::span(values)));
}

bool SameColumns(const std::vector<ColumnSpec>& a, const std::vector<ColumnSpec>& b) {
  return std::ranges::equal(a, b, [](const ColumnSpec& x, const ColumnSpec& y) {
    return x.name == y.name && x.type == y.type && x.shape == y.shape && x.codec == y.codec;
  });
}

}  // namespace

std::optional<uint64_t> HashInFirstFormat(const StepSpec& spec) {
  const Result<DrivingShape> shape = DrivingShape::Find(spec);
  if (!shape) return std::nullopt;
  const StepSpec driving = DrivingStepSpec(*shape);
  if (!SameColumns(spec.observation, driving.observation) || !SameColumns(spec.decision, driving.decision)) {
    return std::nullopt;
  }
  return Hash(*shape);
}

std::optional<StepSpec> SpecOfFirstFormat(uint64_t schema) {
  constexpr int kMost = 64;  // the ranges of observation.vehicles and observation.history are within
  for (int vehicles = 1; vehicles <= kMost; ++vehicles) {
    for (int history = 1; history <= kMost; ++history) {
      const DrivingShape shape{.vehicles = vehicles, .history = history};
      if (Hash(shape) == schema) return DrivingStepSpec(shape);
    }
  }
  return std::nullopt;
}

std::string_view ArrayNameInFirstFormat(std::string_view name) {
  if (name == "action") return "actions";
  if (name == "has_decision") return "has_action";
  return name;
}

}  // namespace dadrl
