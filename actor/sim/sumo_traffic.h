// An episode's traffic inside libsumo: loaded by seed, looping for ever, read vehicle by vehicle.
#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "actor/sim/memory_file.h"
#include "actor/sim/scenario.h"
#include "actor/sim/scenario_plan.h"
#include "actor/sim/traffic.h"
#include "actor/sim/world_state.h"
#include "common/util/random.h"

namespace dadrl {

// Every function may throw what libsumo throws. Not thread safe.
class SumoTraffic {
 public:
  // All but the file must outlive it.
  SumoTraffic(const Scenario& scenario, const ProfileSettings& profile, const ScenarioPlan& plan,
              MemoryFile route_file);

  // Draws the drivers of `seed` and starts SUMO anew at time zero. Whatever ran before leaves no trace.
  Status Load(uint64_t seed, const EgoTraffic& ego);

  // Before the first MoveInSumo of the episode; Load must have been told that SUMO does not drive it.
  void AddDrivenEgo();

  // 0.1 s. A vehicle that finished its route enters it again: standing at its start, on a random lane; from
  // then on it arrives at the end of whichever lane it is on (paper code).
  void Step();

  // The vehicles now in the network, ordered by id: the population, and those that the scenario's own files
  // add. The rest waits for room to enter. kInternal: a vehicle vanished.
  Status Read(std::vector<SocialVehicle>& vehicles) const;

  bool ego_in_network() const { return ego_in_network_; }
  // Since Load: the ego's route in SUMO ended.
  bool ego_arrived() const { return ego_arrived_; }

 private:
  std::vector<std::string> SumoOptions(uint64_t seed) const;
  // Of `id`; a vehicle that was never seen before gets the next number.
  size_t IndexOf(const std::string& id);
  void Enter(const std::string& id);
  void Leave(const std::string& id);
  void Reenter(size_t vehicle);

  const Scenario& scenario_;
  const ProfileSettings& profile_;
  const ScenarioPlan& plan_;
  MemoryFile route_file_;
  Random loop_random_{0};

  struct Vehicle {
    std::string id;
    // False before it first enters, again whenever it has finished its loop, and while SUMO teleports it.
    bool in_network = false;
    int trip = 0;
    double length_m = kVehicleLength;
    double width_m = kVehicleWidth;
  };
  // The population first; then those of the scenario's own files, as they come.
  std::vector<Vehicle> vehicles_;
  std::unordered_map<std::string, size_t> others_;  // by id: those after the population
  bool true_size_ = false;                          // the profile says what the population is
  bool ego_in_network_ = false;
  bool ego_arrived_ = false;
};

}  // namespace dadrl
