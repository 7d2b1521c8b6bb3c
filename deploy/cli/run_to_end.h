// Drives a job of episodes (EvaluationJob, SelectionJob) until it is done, with a count on a terminal.
#pragma once

#include <poll.h>
#include <unistd.h>

#include <cstdio>
#include <vector>

#include "common/util/result.h"
#include "deploy/local/signals.h"

namespace dadrl {

// Blocks. kUnavailable when the user stopped it.
template <typename Job>
Status RunToEnd(Job& job, SignalWatcher& signals) {
  constexpr int kTickMs = 200;
  const bool terminal = isatty(STDERR_FILENO) == 1;
  while (!job.done()) {
    job.Step();
    std::vector<pollfd> fds = {{.fd = signals.fd(), .events = POLLIN, .revents = 0}};
    job.AppendWaitFds(fds);
    poll(fds.data(), fds.size(), kTickMs);
    if (signals.PauseRequested()) signals.PauseWith(job.RunningPids());
    if (signals.StopRequested()) {
      return Fail(ErrorCode::kUnavailable, "stopped after {} of {} episodes", job.finished_episodes(),
                  job.planned_episodes());
    }
    if (terminal) fmt::print(stderr, "\r{} of {} episodes", job.finished_episodes(), job.planned_episodes());
  }
  if (terminal) fmt::print(stderr, "\r\x1b[K");
  return {};
}

}  // namespace dadrl
