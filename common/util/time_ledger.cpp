#include "common/util/time_ledger.h"

#include <numeric>

namespace dadrl {

std::string_view ActivityName(Activity activity) {
  switch (activity) {
    case Activity::kWork:
      return "work";
    case Activity::kWaitForReplay:
      return "replay";
    case Activity::kWaitForWeights:
      return "weights";
    case Activity::kWaitForInserts:
      return "inserts";
    case Activity::kWaitForSamples:
      return "samples";
    case Activity::kWaitForBatch:
      return "batch";
    case Activity::kWaitForDisk:
      return "disk";
    case Activity::kWaitForCredits:
      return "credits";
    case Activity::kWaitForSimulator:
      return "simulator";
    case Activity::kCount:
      break;
  }
  return "unknown";
}

double ActivityTotals::AllSeconds() const {
  return std::accumulate(begin(), end(), 0.0,
                         [](double sum, const TimeSpent& spent) { return sum + spent.seconds; });
}

void TimeLedger::Enter(Activity activity) {
  MutexLock lock(mutex_);
  const TimePoint now = clock_.Now();
  if (current_ != Activity::kCount) totals_[current_].seconds += ToSeconds(now - since_);
  if (activity != current_) ++totals_[activity].count;
  current_ = activity;
  since_ = now;
}

ActivityTotals TimeLedger::Read() const {
  MutexLock lock(mutex_);
  ActivityTotals totals = totals_;
  if (current_ != Activity::kCount) totals[current_].seconds += ToSeconds(clock_.Now() - since_);
  return totals;
}

}  // namespace dadrl
