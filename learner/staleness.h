// How old the policies are whose experience is trained on: in versions and in seconds.
#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "common/step/trajectory_batch.h"

namespace dadrl {

// Mean and maximum over the steps of an interval.
struct Staleness {
  double versions_mean = 0.0;
  double versions_max = 0.0;
  double seconds_mean = 0.0;
  double seconds_max = 0.0;
};

// A step is as stale as the policy that acted is older than the newest one: in versions, and in seconds
// between their publications. Remembers the last 4096 publications; what is older, or random driving before
// the first version, counts as old as the oldest remembered. Not thread safe.
class StalenessTracker {
 public:
  static constexpr size_t kRemembered = 4096;

  // `newest` and the wall times of the last versions up to it, as a checkpoint holds them.
  StalenessTracker(uint32_t newest, std::span<const int64_t> published_ns);

  void OnPublish(uint32_t version, int64_t wall_ns);
  // The policies that acted in the steps of one batch; what lies behind a trajectory's end counts for
  // nothing.
  void Add(const TrajectoryBatch& batch);

  // Over what was added since the last call; all zero when nothing was.
  Staleness TakeInterval();

  uint32_t newest() const { return newest_; }
  std::vector<int64_t> published_ns() const { return {published_ns_.begin(), published_ns_.end()}; }

 private:
  void AddStep(uint32_t acting_version);

  uint32_t newest_;
  std::deque<int64_t> published_ns_;  // the last is newest_'s
  double versions_sum_ = 0.0;
  double seconds_sum_ = 0.0;
  uint64_t count_ = 0;
  Staleness max_;  // only the maxima are used
};

}  // namespace dadrl
