// The driving task as an agent sees it: reset, observe, act.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "actor/task/episode_summary.h"
#include "common/config/config.h"
#include "common/step/driving_shape.h"
#include "common/step/observation.h"
#include "common/util/result.h"

namespace dadrl {

class DrivingEnvironment;

// What one decision led to.
struct StepResult {
  // Summed over the decision's simulation steps, discounted by gamma^(1/decision_interval) a step.
  float reward = 0.0f;
  bool terminated = false;  // collision, off-road, goal: nothing follows
  bool truncated = false;   // time limit: the value goes on
  bool ended() const { return terminated || truncated; }
};

// Not thread safe; create and use it on one thread.
class Environment {
 public:
  virtual ~Environment() = default;

  // Starts the episode of `seed`: same seed, same episode, bit for bit. Loads the traffic, warms it up,
  // spawns the ego. kUnavailable: the ego could not be spawned (try another seed); kInternal: the simulator
  // failed, a next Reset is a clean start.
  virtual Status Reset(uint64_t seed) = 0;

  // Holds `action` for task.decision_interval simulation steps, or until the episode ends.
  // kInvalidArgument: the action is not finite, nothing was stepped. kInternal: the simulator failed; the
  // episode is lost, Reset starts the next.
  virtual Result<StepResult> Step(const Action& action) = 0;

  // After Reset or Step; valid until the next of either.
  virtual const Observation& observation() const = 0;
  // After a Step that ended the episode.
  virtual const EpisodeSummary& summary() const = 0;
  // After Reset: the environment that the episode is driven in, for drivers that look at more than the
  // observation; null where there is none.
  virtual const DrivingEnvironment* driving() const { return nullptr; }
};

// Checks the configuration, finds the scenario's files. With the scenario "all" each episode's seed draws
// one. kInvalidArgument names an unknown scenario and the nearest one.
Result<std::unique_ptr<Environment>> MakeDrivingEnvironment(const Config& config);

}  // namespace dadrl
