#include "common/util/clock.h"

#include <ctime>
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

Duration ProcessCpuTime() {
  timespec spent{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &spent);
  return std::chrono::seconds(spent.tv_sec) + std::chrono::nanoseconds(spent.tv_nsec);
}

}  // namespace dadrl
