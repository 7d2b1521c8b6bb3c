// Turns a target speed and a lane command into wheel and pedal: follows the paths that lead along the route.
#pragma once

#include <memory>
#include <vector>

#include "actor/ego/paths.h"
#include "actor/sim/road_map.h"
#include "actor/sim/route.h"
#include "actor/sim/world_state.h"

namespace dadrl {

// What wheel and pedals are asked to do.
struct EgoCommand {
  double target_speed_mps = 0.0;  // after the curves' limits
  double target_steering_rad = 0.0;
};

// Follows lanes and changes them on command, like the "lane with continuous speed" controller of the paper's
// simulator. The command counts from the path the ego is on now: hold it until the change is past its middle,
// or the ego returns. Where a lane forks, it chooses the branch. Holding it for longer than a change takes
// does nothing where there is no further path. Cheap to copy, to try out what would happen. Not thread safe,
// and neither are two copies.
class EgoController {
 public:
  EgoController(const RoadMap& map, const Route& route);

  // Forgets the last episode: the ego is where the route starts.
  void Reset();

  // Once a simulation step. `target_speed_mps` >= 0; `lane_command` -1: right, 0: keep, +1: left.
  EgoCommand Control(const EgoState& ego, double target_speed_mps, int lane_command);

  // The path the ego is on, and the one it steers along; they differ during a lane change.
  const Path& current_path() const { return paths_->data()[current_]; }
  const Path& followed_path() const { return paths_->data()[followed_]; }
  const std::vector<Path>& paths() const { return *paths_; }

 private:
  void Localize(const EgoState& ego, int lane_command);
  bool Drivable(const EgoState& ego, size_t path) const;
  int Neighbour(const EgoState& ego, int lane_command) const;
  double Steer(const EgoState& ego, const Polyline::Projection& projection) const;
  double CurveSpeed(const EgoState& ego, const Polyline::Projection& projection) const;

  std::shared_ptr<const std::vector<Path>> paths_;  // shared by copies: it never changes
  std::shared_ptr<PathSides> sides_;                // of these; shared by copies: what one asks, all know
  int initial_ = 0;
  int current_ = 0;
  int followed_ = 0;
  bool changing_lane_ = false;
  std::vector<Polyline::Projection> projections_;  // of the ego, now: on the current path, on all when needed
};

}  // namespace dadrl
