// What a process cannot do at the moment: faults that last, such as a full disk, and until when.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/util/clock.h"
#include "common/util/enum_array.h"
#include "common/util/mutex.h"
#include "common/util/result.h"

namespace dadrl {

// By what is not done, whatever the cause; the text says that.
enum class FaultKind : int {
  kExperience = 0,  // replay: new experience is not stored
  kSync,            // replay: what is stored is not forced to the device
  kState,           // replay: counters and priorities are not saved
  kDamage,          // replay: some of what is stored cannot be read any more
  kSnapshot,        // replay: no automatic snapshot is taken
  kSnapshotSpace,   // replay: snapshots hold more of the disk than the replay itself may
  kCheckpoint,      // learner: no checkpoint is saved
  kWeights,         // learner: new policies are not sent
  kTrainingLog,     // learner: training.csv or TensorBoard's file is not written
  kEpisodeLog,      // launcher and actors: episodes are not written down
  kIncarnation,     // that this process was started is not written down
  kResults,         // launcher: results.json or the record of a choice is not written
  kProcesses,       // launcher: processes.json is not written
  kCount,
};

// Stable snake_case name ("training_log").
std::string_view FaultName(FaultKind kind);
// What it means for the training, a sentence without a full stop.
std::string_view FaultMeaning(FaultKind kind);
// What to say when it is over.
std::string_view FaultOver(FaultKind kind);
// Whether training comes to a stand sooner or later while it lasts.
bool HoldsUpTraining(FaultKind kind);

struct Fault {
  FaultKind kind = FaultKind::kExperience;
  std::string text;      // the cause, in the words of the error
  double since_s = 0.0;  // how long it has lasted
  bool operator==(const Fault&) const = default;
};

// The faults of a process. Thread safe.
class FaultBoard {
 public:
  // Whether the log says when each begins and when it is over.
  enum class Logging { kOn, kOff };

  // Borrows `clock`.
  explicit FaultBoard(const Clock& clock, Logging logging = Logging::kOn)
      : clock_(clock), logging_(logging) {}

  // The outcome of an attempt at what `kind` is about: an error begins or prolongs the fault (the first text
  // stays), success ends it.
  void Report(FaultKind kind, const Status& outcome) DADRL_EXCLUDES(mutex_);
  // Tells `follower`, from now on, what holds up training, whenever that changes: the text of the first such
  // fault that lasts, empty when none does. It is called under the board's lock, on any thread. Before any
  // thread.
  void Follow(std::function<void(std::string_view held_up_by)> follower) DADRL_EXCLUDES(mutex_);
  // Those that last, by kind.
  std::vector<Fault> Current() const DADRL_EXCLUDES(mutex_);
  bool Lasts(FaultKind kind) const DADRL_EXCLUDES(mutex_);

 private:
  struct Lasting {
    std::string text;
    TimePoint since{};
  };
  std::string HeldUpBy() const DADRL_REQUIRES(mutex_);

  const Clock& clock_;
  const Logging logging_;
  mutable Mutex mutex_;
  std::function<void(std::string_view)> follower_ DADRL_GUARDED_BY(mutex_);
  EnumArray<FaultKind, std::optional<Lasting>> lasting_ DADRL_GUARDED_BY(mutex_);
};

// The board of this process, on the real clock: as its log, one for all that it does.
FaultBoard& ProcessFaults();

}  // namespace dadrl
