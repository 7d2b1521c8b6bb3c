#include "learner/staleness.h"

#include <algorithm>
#include <utility>

namespace dadrl {

StalenessTracker::StalenessTracker(uint32_t newest, std::span<const int64_t> published_ns)
    : newest_(newest),
      published_ns_(published_ns.end() - static_cast<long>(std::min(published_ns.size(), kRemembered)),
                    published_ns.end()) {}

void StalenessTracker::OnPublish(uint32_t version, int64_t wall_ns) {
  // Versions that a restart skipped were never broadcast: nobody acts with them, any time fits.
  for (uint32_t skipped = newest_ + 1; skipped < version && !published_ns_.empty(); ++skipped) {
    published_ns_.push_back(published_ns_.back());
    if (published_ns_.size() > kRemembered) published_ns_.pop_front();
  }
  newest_ = version;
  published_ns_.push_back(wall_ns);
  if (published_ns_.size() > kRemembered) published_ns_.pop_front();
}

void StalenessTracker::Add(const TrajectoryBatch& batch) {
  const auto count = static_cast<size_t>(batch.shape.count);
  for (size_t b = 0; b < count; ++b) {
    for (size_t t = 0; std::cmp_less(t, batch.steps[b]); ++t) AddStep(batch.policy_versions[t * count + b]);
  }
}

void StalenessTracker::AddStep(uint32_t acting_version) {
  // A restored learner may briefly be behind what an actor got from the one before it.
  const uint32_t behind = newest_ - std::min(acting_version, newest_);
  double seconds = 0.0;
  if (!published_ns_.empty()) {
    const size_t back = std::min<size_t>(behind, published_ns_.size() - 1);
    // A wall clock set back must not make experience come from the future.
    seconds = std::max(0.0, 1e-9 * (published_ns_.back() - published_ns_[published_ns_.size() - 1 - back]));
  }
  versions_sum_ += behind;
  seconds_sum_ += seconds;
  max_.versions_max = std::max<double>(max_.versions_max, behind);
  max_.seconds_max = std::max(max_.seconds_max, seconds);
  ++count_;
}

Staleness StalenessTracker::TakeInterval() {
  Staleness interval = max_;
  if (count_ > 0) {
    interval.versions_mean = versions_sum_ / count_;
    interval.seconds_mean = seconds_sum_ / count_;
  }
  versions_sum_ = 0.0;
  seconds_sum_ = 0.0;
  count_ = 0;
  max_ = {};
  return interval;
}

}  // namespace dadrl
