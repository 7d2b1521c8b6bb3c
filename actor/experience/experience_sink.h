// Where an actor's experience goes, and where its policy comes from: the two seams between driving and the
// network.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/step/observation.h"
#include "common/util/result.h"

namespace dadrl {

// Takes the frames of one episode after another. Called by the simulation thread only; never blocks on the
// network (a full backlog is visible as `blocked`, and the caller waits outside the simulator).
class ExperienceSink {
 public:
  virtual ~ExperienceSink() = default;
  virtual void BeginEpisode(uint64_t episode) = 0;
  // A step: what was seen, the values of the decision columns, what came of it.
  virtual void AddTransition(const Observation& observation, std::span<const float> decision, float reward,
                             uint8_t flags, uint32_t policy_version) = 0;
  virtual void AddFinal(const Observation& observation) = 0;
  // Hands over what is buffered; after it the episode is complete (or was cut by a failed simulator).
  virtual void EndEpisode() = 0;
  // True while the backlog of unacknowledged bytes is at its bound: add nothing until it is false.
  virtual bool blocked() const = 0;
};

// The newest published policy, pulled without blocking by the simulation thread.
class PolicySource {
 public:
  virtual ~PolicySource() = default;
  // Copies the newest parameters into `parameters` and returns their version when it is newer than `have`,
  // else 0.
  virtual uint32_t TakeNewer(uint32_t have, std::vector<float>& parameters) = 0;
};

}  // namespace dadrl
