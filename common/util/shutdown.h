// SIGINT and SIGTERM as a flag that loops poll: a process drains, saves and leaves; it is never cut in half.
#pragma once

#include <atomic>
#include <csignal>

namespace dadrl {

// Set by the first SIGINT or SIGTERM after InstallShutdownHandler.
inline std::atomic<bool> shutdown_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "the handler may only touch lock-free atomics");

inline void InstallShutdownHandler() {
  struct sigaction action {};
  action.sa_handler = [](int) { shutdown_requested.store(true); };
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

}  // namespace dadrl
