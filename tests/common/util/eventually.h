// Waits for what other threads and processes do.
#pragma once

#include <chrono>
#include <functional>
#include <thread>

namespace dadrl {

// Polls until `condition` holds; false when it does not within `limit`: a bound for broken code, not a delay,
// and generous, since machines are busy.
inline bool Eventually(const std::function<bool()>& condition,
                       std::chrono::duration<double> limit = std::chrono::seconds(30)) {
  const auto deadline = std::chrono::steady_clock::now() + limit;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return condition();
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

}  // namespace dadrl
