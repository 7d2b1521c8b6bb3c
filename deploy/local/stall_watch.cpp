#include "deploy/local/stall_watch.h"

#include <utility>

namespace dadrl {

std::string StallWatch::Look(TimePoint now, uint64_t updates, uint64_t frames) {
  const bool stored = std::exchange(frames_, frames) != frames;
  const bool trained = updates > most_updates_;
  if (trained) most_updates_ = updates;
  if (stored || trained) {
    begun_ = true;
    moved_ = now;
  }
  const Duration still = now - moved_;
  const bool stalled_before = std::exchange(stalled_, still > (begun_ ? kPatience : kFirstPatience));
  if (stalled_ && !stalled_before) overdue_ = still;
  if (stalled_) return "neither an update nor a stored frame";
  if (updates > 0 && updates < most_updates_) return "the learner repeats updates that were lost";
  return {};
}

Duration StallWatch::TakeOverdue() { return std::exchange(overdue_, Duration::zero()); }

}  // namespace dadrl
