// How much of a training's time went to faults, and to which: what decides whether a run that ended by its
// clock has done its work.
#pragma once

#include <map>
#include <span>
#include <string>

#include "common/util/clock.h"

namespace dadrl {

// Pure: time is passed in. Not thread safe.
class LostTime {
 public:
  // A run that lost less than this in all is never held up by it: a restart or two are no fault of a short
  // run.
  static constexpr Duration kNegligible = std::chrono::seconds(20);

  // From the last call to `now`, training was held up by `faults`; by nothing when there are none. Each is
  // one line that does not change while it lasts ("replay-0 hangs"): equal ones are summed up. Of several
  // at once the first counts.
  void Observe(TimePoint now, std::span<const std::string> faults);
  // Time until `now` that belongs to nothing: the run was kept stopped, or was not training.
  void Skip(TimePoint now);
  // Time that is known too late to be lost to `fault`.
  void Add(const std::string& fault, Duration lost);

  Duration total() const;
  // By fault.
  const std::map<std::string, Duration>& by_fault() const { return by_fault_; }
  // More than half of `trained`, and no trifle.
  bool HeldUp(Duration trained) const;
  // "412 of 600 s lost to faults: 380 s replay-0 hangs, 32 s learner starts again"; empty when nothing was.
  std::string Sentence(Duration trained) const;

 private:
  bool begun_ = false;
  TimePoint last_{};
  std::map<std::string, Duration> by_fault_;
};

}  // namespace dadrl
