#include "common/util/clock.h"

#include <thread>

namespace dadrl {

TimePoint SystemClock::Now() const { return std::chrono::steady_clock::now(); }

void SystemClock::SleepFor(Duration duration) { std::this_thread::sleep_for(duration); }

int64_t SystemClock::WallTimeNs() const { return dadrl::WallTimeNs(); }

int64_t WallTimeNs() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace dadrl
