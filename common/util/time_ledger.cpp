#include "common/util/time_ledger.h"

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

void TimeLedger::Enter(Activity activity) {
  MutexLock lock(mutex_);
  const TimePoint now = clock_.Now();
  if (current_ != Activity::kCount) seconds_[static_cast<size_t>(current_)] += ToSeconds(now - since_);
  current_ = activity;
  since_ = now;
}

TimeLedger::Totals TimeLedger::Read() const {
  MutexLock lock(mutex_);
  Totals totals = seconds_;
  if (current_ != Activity::kCount) totals[static_cast<size_t>(current_)] += ToSeconds(clock_.Now() - since_);
  return totals;
}

}  // namespace dadrl
