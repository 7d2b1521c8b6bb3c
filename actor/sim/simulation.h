// Traffic around the ego: SUMO inside the process, reset by seed and stepped by 0.1 s.
#pragma once

#include <cstdint>
#include <memory>

#include "actor/sim/road_map.h"
#include "actor/sim/route.h"
#include "actor/sim/scenario.h"
#include "actor/sim/world_state.h"
#include "common/config/config.h"
#include "common/util/result.h"

namespace dadrl {

// Who moves the ego: the caller (Step(EgoState)) or SUMO's own driver along the route (StepSumoDriver).
enum class EgoDriver { kCaller, kSumo };

struct SimulationOptions {
  TrafficProfile profile = TrafficProfile::kCalibrated;
  double max_speed_mps = 10.0;  // of the ego
  EgoDriver ego_driver = EgoDriver::kCaller;
  double sumo_driver_impatience = 0.0;  // in [0, 1]: willingness to take the right of way
  int spawn_limit_steps = 600;          // how long the ego waits for a free start
};

// libsumo holds one simulation a process. A process may have several of these, all on one thread: the one
// that was created or reset last is the one that runs, and stepping another is kInternal until it is reset.
// Not thread safe. Nothing is written to standard output.
class Simulation {
 public:
  // Loads the network and checks the scenario against it. kInvalidArgument: SUMO cannot read the
  // network, a lane or edge is not there or not open, or SUMO refuses the traffic; with place and remedy.
  static Result<std::unique_ptr<Simulation>> Create(const Scenario& scenario,
                                                    const SimulationOptions& options);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  const RoadMap& map() const;
  const Route& route() const;
  // Whether map and SUMO have only what is near route and flows (network_crop.h).
  bool network_is_cut() const;

  // Starts the episode of `seed`: draws the drivers, warms the traffic up, waits until no vehicle's centre is
  // closer than a vehicle's length to the start, and places the ego there with min(lane limit, max speed).
  // The same seed gives the same episode, bit for bit, whatever ran before. Tens of milliseconds.
  // kUnavailable: the start stayed blocked. kInternal: SUMO failed; another Reset is a clean start.
  Status Reset(uint64_t seed);

  // Moves the ego to `ego` and the traffic by 0.1 s. With EgoDriver::kCaller only.
  // kInvalidArgument: `ego` is not finite; nothing happened. kInternal: SUMO failed, or a vehicle or the ego
  // vanished; the episode is lost, Reset starts the next.
  Status Step(const EgoState& ego);
  // Lets SUMO drive the ego for 0.1 s. With EgoDriver::kSumo only. Errors as above.
  Status StepSumoDriver();

  // After Reset or Step; valid until the next of either. Vehicles ordered by id.
  const WorldState& world() const;
  // True once SUMO's driver has left at the end of the route; world().ego then stays where it was last.
  bool ego_arrived() const;

 private:
  class Impl;
  Simulation();
  Status CheckHeld() const;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dadrl
