#include "deploy/local/restart_policy.h"

#include <algorithm>
#include <cmath>
#include <csignal>

#include "common/util/exit_code.h"

namespace dadrl {

RestartDecision RestartPolicy::OnEnd(TimePoint now, const Ended& ended) {
  if (ended.uptime >= limits_.stable_after) in_a_row_ = 0;
  ++in_a_row_;
  failures_.push_back(now);
  while (failures_.front() + limits_.window < now) failures_.pop_front();

  // A SIGKILL comes from outside (a user, the out-of-memory killer): it says nothing about start-up.
  const bool killed = !ended.hung && ended.status.signaled && ended.status.value == SIGKILL;
  if (ended.was_ready) before_ready_in_a_row_ = 0;
  if (!ended.was_ready && !killed) ++before_ready_in_a_row_;

  if (!ended.status.signaled && ended.status.value == kExitTurnedAway) {
    return GiveUp{"another process has its place in the run"};
  }
  if (!ended.was_ready && !ended.status.signaled && ended.status.value == 2) {
    return GiveUp{"it refuses its configuration"};
  }
  if (before_ready_in_a_row_ >= limits_.max_failures_before_ready) {
    return GiveUp{fmt::format("it failed {} times before it was ready", before_ready_in_a_row_)};
  }
  if (std::ssize(failures_) >= limits_.max_failures) {
    return GiveUp{fmt::format("it failed {} times within {:g} minutes", failures_.size(),
                              ToSeconds(limits_.window) / 60.0)};
  }
  const double delay_s = std::min(ToSeconds(limits_.first_delay) * std::pow(limits_.factor, in_a_row_ - 1),
                                  ToSeconds(limits_.max_delay));
  return RestartAfter{FromSeconds(delay_s * random_.Uniform(1.0, 1.2))};
}

}  // namespace dadrl
