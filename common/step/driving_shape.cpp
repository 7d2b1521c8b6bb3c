#include "common/step/driving_shape.h"

namespace dadrl {

StepSpec DrivingStepSpec(const DrivingShape& shape) {
  constexpr float kBound = DrivingShape::kFeatureBound;
  StepSpec spec = {
      .observation = {{"vehicles",
                       ElementType::kFloat32,
                       {shape.vehicles, shape.history, DrivingShape::kVehicleFeatures},
                       ColumnCodec::kHistory,
                       kBound},
                      {"ego",
                       ElementType::kFloat32,
                       {shape.history, DrivingShape::kEgoFeatures},
                       ColumnCodec::kHistory,
                       kBound},
                      {"context",
                       ElementType::kBit,
                       {DrivingShape::kContextPlanes, DrivingShape::kContextSize, DrivingShape::kContextSize},
                       ColumnCodec::kBitPlanes}},
      .decision = {{"action", ElementType::kFloat32, {kActionSize}, ColumnCodec::kRaw, 1.0f}}};
  if (shape.polylines) {
    spec.observation.push_back({"polylines",
                                ElementType::kFloat32,
                                {shape.ways(), DrivingShape::kWayPoints, DrivingShape::kPointFeatures},
                                ColumnCodec::kHistory,
                                kBound});
  }
  return spec;
}

StepSpec DrivingStepSpec(const Config& config) {
  StepSpec spec = DrivingStepSpec(DrivingShape::From(config.observation));
  if (config.model.log_probability) spec.decision.push_back({.name = "log_probability"});
  return spec;
}

DrivingShape::operator StepSpec() const { return DrivingStepSpec(*this); }

Result<DrivingShape> DrivingShape::Find(const StepSpec& spec) {
  DrivingShape shape;
  DADRL_ASSIGN_OR_RETURN(shape.vehicles_column,
                         FindColumn(spec.observation, "vehicles", ElementType::kFloat32, 3));
  DADRL_ASSIGN_OR_RETURN(shape.ego_column, FindColumn(spec.observation, "ego", ElementType::kFloat32, 2));
  DADRL_ASSIGN_OR_RETURN(shape.context_column, FindColumn(spec.observation, "context", ElementType::kBit, 3));
  if (const auto found = FindColumn(spec.observation, "polylines", ElementType::kFloat32, 3)) {
    shape.polylines = true;
    shape.polylines_column = *found;
  }
  const std::vector<int>& vehicles = spec.observation[shape.vehicles_column].shape;
  shape.vehicles = vehicles[0];
  shape.history = vehicles[1];
  const StepSpec expected = DrivingStepSpec(shape);
  const size_t columns[] = {shape.vehicles_column, shape.ego_column, shape.context_column,
                            shape.polylines_column};
  for (size_t i = 0; i < expected.observation.size(); ++i) {
    if (spec.observation[columns[i]].shape == expected.observation[i].shape) continue;
    return Fail(ErrorCode::kInvalidArgument, "driving networks need {}; the steps of this run have {}",
                ColumnsText(expected.observation), ColumnsText(spec.observation));
  }
  return shape;
}

}  // namespace dadrl
