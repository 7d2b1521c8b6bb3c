// The ego's senses: an Observation of the scene, as features.h and birds_eye_view.h define it.
#pragma once

#include "actor/sensing/birds_eye_view.h"
#include "actor/sensing/history.h"
#include "actor/sensing/localization.h"
#include "actor/sensing/polylines.h"
#include "common/config/config.h"
#include "common/step/driving_shape.h"
#include "common/step/observation.h"

namespace dadrl {

// Borrows map and route. Not thread safe.
class Sensor {
 public:
  Sensor(const RoadMap& map, const Route& route, const ObservationConfig& config)
      : shape_(DrivingShape::From(config)),
        route_(route),
        history_(config),
        view_(map, route),
        ways_(map, route) {}

  // An episode starts.
  void Reset() { history_.Clear(); }
  // Once a simulation step, the scene at spawn included.
  void Update(const WorldState& world, const EgoLocation& location) {
    history_.Push(world, location);
    ego_ = world.ego;
    route_s_ = location.route_s;
  }
  // The scene updated last, into an observation of this configuration's spec, a line a column; allocates
  // nothing.
  void Observe(Observation& out) {
    history_.WriteVehicles(out.floats(shape_.vehicles_column));
    history_.WriteEgo(route_.goal(), out.floats(shape_.ego_column));
    view_.Draw(ego_.pose, route_s_, out.bits(shape_.context_column));
    if (shape_.polylines) WritePolylines(out.floats(shape_.polylines_column));
  }

 private:
  // Of the vehicles that were just written, in their order.
  void WritePolylines(std::span<float> out) {
    const size_t each = out.size() / static_cast<size_t>(1 + shape_.vehicles);
    ways_.WriteEgo(ego_, route_s_, out.first(each));
    for (size_t i = 0; i < history_.nearest_count(); ++i) {
      ways_.WriteVehicle(ego_, history_.nearest(i), out.subspan((1 + i) * each, each));
    }
    WriteNoWays(out.subspan((1 + history_.nearest_count()) * each));
  }

  const DrivingShape shape_;
  const Route& route_;
  History history_;
  BirdsEyeView view_;
  Polylines ways_;
  EgoState ego_;
  double route_s_ = 0.0;
};

}  // namespace dadrl
