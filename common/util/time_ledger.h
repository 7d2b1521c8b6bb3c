// Where a thread's time goes: working, or waiting, and for what. The monitor's "who waits for whom" comes
// from here.
#pragma once

#include <array>
#include <string_view>

#include "common/util/clock.h"
#include "common/util/mutex.h"

namespace dadrl {

// What a process spends its time on. kWork is being useful; every other value is a wait with its reason.
enum class Activity : int {
  kWork = 0,
  kWaitForReplay,     // actor: the replay has not acknowledged, or is not there
  kWaitForWeights,    // actor: no policy has arrived yet
  kWaitForInserts,    // replay and learner: too little experience (minimum size, or samples per insert too
                      // high)
  kWaitForSamples,    // replay: inserts are held back until the learner has sampled more
  kWaitForBatch,      // learner: the next batch is under way
  kWaitForDisk,       // replay and learner: writing or syncing a file
  kWaitForCredits,    // replay: the learner has no request outstanding
  kWaitForSimulator,  // actor: SUMO is loading or warming up
  kCount,
};

// Short stable name, used in the monitor and its JSON ("inserts", "samples", ...).
std::string_view ActivityName(Activity activity);

// Accumulates seconds per activity. One thread calls Enter; any thread may read Totals.
class TimeLedger {
 public:
  using Totals = std::array<double, static_cast<size_t>(Activity::kCount)>;

  // Borrows `clock`; time before the first Enter is not counted.
  explicit TimeLedger(const Clock& clock) : clock_(clock) {}

  // Ends the running activity and starts `activity`.
  void Enter(Activity activity) DADRL_EXCLUDES(mutex_);
  // Cumulative seconds by activity, the running one included up to now.
  Totals Read() const DADRL_EXCLUDES(mutex_);

 private:
  const Clock& clock_;
  mutable Mutex mutex_;
  Totals seconds_ DADRL_GUARDED_BY(mutex_){};
  Activity current_ DADRL_GUARDED_BY(mutex_) = Activity::kCount;
  TimePoint since_ DADRL_GUARDED_BY(mutex_){};
};

// Enters `activity` for its own lifetime, then goes back to kWork.
class ScopedActivity {
 public:
  ScopedActivity(TimeLedger& ledger, Activity activity) : ledger_(ledger) { ledger_.Enter(activity); }
  ~ScopedActivity() { ledger_.Enter(Activity::kWork); }
  ScopedActivity(const ScopedActivity&) = delete;
  ScopedActivity& operator=(const ScopedActivity&) = delete;

 private:
  TimeLedger& ledger_;
};

}  // namespace dadrl
