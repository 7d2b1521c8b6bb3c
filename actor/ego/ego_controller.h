// Turns a target speed and a lane command into wheel and pedal: follows the paths that lead along the route.
#pragma once

#include <vector>

#include "actor/ego/paths.h"
#include "actor/sim/road_map.h"
#include "actor/sim/route.h"
#include "actor/sim/world_state.h"

namespace dadrl {

// What the wheel and the pedals are asked to do.
struct EgoCommand {
  double target_speed_mps = 0.0;  // after the curve limits
  double target_steering_rad = 0.0;
};

// Lane-following with lane commands, as the paper's "lane with continuous speed" controller. Each step the
// command is relative to the path the ego is on now: hold it until the change is half done, or the ego
// returns. Where the road forks, the command chooses the branch. Not thread safe.
class EgoController {
 public:
  // The map and the route must outlive the controller.
  EgoController(const RoadMap& map, const Route& route);

  // Forgets everything; the ego stands at the route's start.
  void Reset();

  // `target_speed_mps` >= 0; `lane_command` is -1 (right), 0 or +1 (left).
  EgoCommand Control(const EgoState& ego, double target_speed_mps, int lane_command);

  // The path the ego is on, and the one it follows; they differ during a lane change.
  const Path& current_path() const { return paths_[static_cast<size_t>(current_)]; }
  const Path& followed_path() const { return paths_[static_cast<size_t>(followed_)]; }
  const std::vector<Path>& paths() const { return paths_; }

 private:
  void Localize(const EgoState& ego);
  int Neighbour(const EgoState& ego, int lane_command) const;
  double Steer(const EgoState& ego, int lane_command);
  double CurveLimit(const EgoState& ego) const;

  std::vector<Path> paths_;  // rightmost first
  int initial_ = 0;
  int current_ = 0;
  int followed_ = 0;
  bool changing_lane_ = false;
};

}  // namespace dadrl
