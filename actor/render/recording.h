// A driven episode, kept whole: what the pictures show.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "actor/drive_command.h"
#include "actor/policies/driving_policy.h"
#include "actor/sim/road_map.h"
#include "actor/sim/route.h"
#include "actor/sim/world_state.h"
#include "actor/task/episode_summary.h"
#include "actor/task/events.h"
#include "actor/task/reward.h"
#include "common/util/result.h"

namespace dadrl {

// How much of its attention the policy gives to one vehicle.
struct Attention {
  int vehicle = 0;      // SocialVehicle::id
  double weight = 0.0;  // in [0, 1]
};

// The scene after a number of simulation steps.
struct Moment {
  WorldState world;
  Events events;                        // of the step that led here; none at the start
  RewardTerms reward;                   // of that step
  RewardTerms reward_so_far;            // of all steps until here
  std::optional<DriveCommand> command;  // in force from here on; none where SUMO drives
  std::vector<Attention> attention;     // of the last decision; empty without a learned policy
  std::vector<uint8_t> context;         // column `context` of the observation
};

// Immutable once recorded.
struct Recording {
  std::string scenario;
  std::string policy;
  RoadMap map;
  Route route;
  double max_speed_mps = 0.0;        // of a policy's actions
  double sensor_radius_m = 0.0;      // vehicles farther away are not observed
  std::vector<Moment> moments;       // [steps + 1], the scene at spawn first
  EpisodeSummary summary;            // of the whole episode
  std::optional<int> collided_with;  // SocialVehicle::id
};

// Drives the episode of `seed` and keeps every simulation step. `policy_name` is for the reader.
// Errors as Environment.
Result<Recording> RecordEpisode(DrivingEnvironment& environment, DrivingPolicy& policy,
                                const std::string& policy_name, uint64_t seed);

// How it ended, for a reader: "collision with car 12 at 7.3 s".
std::string OutcomeSentence(const Recording& recording);

}  // namespace dadrl
