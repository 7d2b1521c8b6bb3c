// When a process that died is started again, and when that is given up.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <variant>

#include "common/util/clock.h"
#include "common/util/random.h"
#include "deploy/local/child_process.h"

namespace dadrl {

struct RestartLimits {
  Duration first_delay = std::chrono::milliseconds(500);
  Duration max_delay = std::chrono::seconds(30);
  double factor = 2.0;                               // of the delay, from one failure to the next
  Duration stable_after = std::chrono::seconds(60);  // up so long: the delay starts anew
  int max_failures = 20;                             // within `window`
  Duration window = std::chrono::minutes(10);
  int max_failures_before_ready = 4;  // in a row, of a process that never came up
};

// What is known about a process that just ended.
struct Ended {
  ExitStatus status;
  Duration uptime{};
  bool was_ready = false;  // it had come up
  bool hung = false;       // and was killed for it
};

struct RestartAfter {
  Duration delay{};
};
struct GiveUp {
  std::string reason;
};
using RestartDecision = std::variant<RestartAfter, GiveUp>;

// Exponential back-off with up to 20 % jitter, so that many actors do not come back in step. Pure: time is
// passed in. One a process; not thread safe.
class RestartPolicy {
 public:
  RestartPolicy(const RestartLimits& limits, uint64_t seed) : limits_(limits), random_(seed) {}

  // The process ended at `now` although nobody asked it to. Wrong usage (exit code 2) before it was ever
  // ready is given up at once: the same configuration fails the same way. So is, at any time, one whose place
  // in the run another has (kExitTurnedAway).
  RestartDecision OnEnd(TimePoint now, const Ended& ended);

 private:
  RestartLimits limits_;
  Random random_;
  std::deque<TimePoint> failures_;
  int in_a_row_ = 0;  // since it was last stable
  int before_ready_in_a_row_ = 0;
};

}  // namespace dadrl
