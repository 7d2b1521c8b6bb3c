// Where a thread's time goes: working, or waiting, and for what, how often and how long. The monitor's "who
// waits for whom" comes from here.
#pragma once

#include <cstdint>
#include <string_view>

#include "common/util/clock.h"
#include "common/util/enum_array.h"
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

// What an activity came to.
struct TimeSpent {
  uint64_t count = 0;  // how often it began
  double seconds = 0.0;
  bool operator==(const TimeSpent&) const = default;
};

struct ActivityTotals : EnumArray<Activity, TimeSpent> {
  double AllSeconds() const;
};

// Counts and times a thread's activities. One thread at a time calls Enter; any thread may call Read.
class TimeLedger {
 public:
  // Borrows `clock`; time before the first Enter is not counted.
  explicit TimeLedger(const Clock& clock) : clock_(clock) {}

  // Ends the running activity and begins `activity`; goes on with it when it is the running one.
  void Enter(Activity activity) DADRL_EXCLUDES(mutex_);
  // Cumulative, the running one included up to now.
  ActivityTotals Read() const DADRL_EXCLUDES(mutex_);

 private:
  const Clock& clock_;
  mutable Mutex mutex_;
  ActivityTotals totals_ DADRL_GUARDED_BY(mutex_);
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
