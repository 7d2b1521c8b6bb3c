// One episode judged step by step: events, reward, end, metrics.
#pragma once

#include <cstdint>
#include <string>

#include "actor/sensing/localization.h"
#include "actor/sim/world_state.h"
#include "actor/task/episode_summary.h"
#include "actor/task/events.h"
#include "actor/task/metrics.h"
#include "actor/task/reward.h"
#include "common/config/config.h"

namespace dadrl {

struct TaskStep {
  Events events;
  RewardTerms terms;
  bool terminated = false;  // collision, off-road or goal
  bool truncated = false;   // the last step allowed, and not terminated
  bool ended() const { return terminated || truncated; }
};

// Borrows map and route. Not thread safe; a step allocates nothing unless it ends in a collision.
class DrivingTask {
 public:
  DrivingTask(const RoadMap& map, const Route& route, const TaskConfig& config)
      : map_(map), config_(config), detector_(map, route), reward_(config.reward), metrics_(map) {}

  // The episode of `seed` in `scenario` starts at `location`.
  void Begin(const std::string& scenario, uint64_t seed, const EgoLocation& location);
  // The scene after one more simulation step. Not after a step that ended the episode.
  TaskStep Step(const WorldState& world, const EgoLocation& location);
  // The same for a step in which SUMO's driver took the ego out of the network: to the goal, or else
  // off-road.
  TaskStep Leave(const WorldState& world, const EgoLocation& location);

  // Complete after the step that ended the episode.
  const EpisodeSummary& summary() const { return summary_; }

 private:
  TaskStep Judge(const WorldState& world, const EgoLocation& location, const Events& events);

  const RoadMap& map_;
  TaskConfig config_;
  EventDetector detector_;
  RewardFunction reward_;
  EpisodeMetrics metrics_;
  EpisodeSummary summary_;
};

}  // namespace dadrl
