// The faults of a training session (common/util/fault.h): what is told of each on the terminal, once when it
// begins, once when it is over, and at the end. Processes say them by telemetry: for display only.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/util/clock.h"
#include "deploy/monitor/cluster_view.h"

namespace dadrl {

// Not thread safe.
class FaultHistory {
 public:
  // A fault that nobody reports is over after so long only: its process may be about to come back with it.
  static constexpr Duration kGrace = std::chrono::seconds(5);

  // Those that last now; returns what there is to say.
  std::vector<std::string> Update(const std::vector<ProcessFault>& lasting, TimePoint now);

  // "replay-0 experience 35 s, learner training_log 34 s"; empty when there were none.
  std::string Summary() const;

 private:
  struct Entry {
    double seconds = 0.0;  // altogether
    bool lasts = false;
    TimePoint since{};
    TimePoint heard{};  // last
  };
  // The process and what it does not do.
  std::map<std::pair<std::string, FaultKind>, Entry> entries_;
};

}  // namespace dadrl
