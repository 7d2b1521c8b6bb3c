// SIGINT, SIGTERM and SIGHUP as a flag that loops poll: a process drains, saves and leaves; it is never cut
// in half.
#pragma once

#include <atomic>
#include <csignal>

namespace dadrl {

// Set by the first of them after InstallShutdownHandler.
inline std::atomic<bool> shutdown_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "the handler may only touch lock-free atomics");

// One that was ignored when the program started (nohup) stays ignored.
inline void InstallShutdownHandler() {
  for (const int signal_number : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action {};
    sigaction(signal_number, nullptr, &action);
    if (action.sa_handler == SIG_IGN) continue;
    action = {};
    action.sa_handler = [](int) { shutdown_requested.store(true); };
    sigemptyset(&action.sa_mask);
    sigaction(signal_number, &action, nullptr);
  }
}

}  // namespace dadrl
