// The vehicles of an episode as SUMO's route file: a closed population whose drivers are drawn anew each
// episode.
#pragma once

#include <string>
#include <vector>

#include "actor/sim/scenario.h"
#include "common/util/random.h"

namespace dadrl {

// One kind of driver (paper code, scenario files): what SUMO's vType takes.
struct DriverType {
  double speed_factor = 1.0;  // mean wish relative to the limit; SUMO spreads single drivers by 0.1
  double min_gap_m = 2.5;
  double imperfection = 0.5;
  double lane_change_speed_gain = 1.0;
  double lane_change_impatience = 0.0;
  double lane_change_cooperative = 1.0;
  double ignore_standing_foe = 0.0;  // probability
  double impatience = 0.0;
};

// Whether the profile gives the population a class or a size of its own: then vehicles are as long and wide
// as SUMO has them. Otherwise each is the paper's box (world_state.h).
bool SaysWhatDrives(const ProfileSettings& profile);
// SUMO's class of the population: "passenger" unless the profile says otherwise.
std::string VehicleClass(const ProfileSettings& profile);

std::vector<DriverType> SampleDriverTypes(int count, Random& random);

// How the ego appears to SUMO.
struct EgoTraffic {
  std::vector<std::string> edges;
  bool sumo_drives = false;
  double max_speed_mps = 10.0;
  double impatience = 0.0;  // only with sumo_drives
};

constexpr const char* kEgoId = "ego";

// Vehicle i of the population is "v<i>"; it drives flow i / types with type i % types.
std::string SocialId(int vehicle);
// -1 when `id` is not of the population.
int SocialIndex(const std::string& id);
// The SUMO route of a flow, and of a driver type.
std::string FlowId(int flow);
std::string TypeId(int type);

// `lane_end_m[flow]`: SUMO's length of the flow's departure lane.
std::string TrafficXml(const Scenario& scenario, const ProfileSettings& profile,
                       const std::vector<DriverType>& types, const std::vector<double>& lane_end_m,
                       const EgoTraffic& ego);

}  // namespace dadrl
