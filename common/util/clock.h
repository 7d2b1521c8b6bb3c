// Time is passed in, so limiters, retries and back-offs are tested without sleeping.
#pragma once

#include <chrono>
#include <cstdint>

namespace dadrl {

using Duration = std::chrono::nanoseconds;
// Monotonic; comparable within one process only.
using TimePoint = std::chrono::time_point<std::chrono::steady_clock, Duration>;

// Thread safe.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual TimePoint Now() const = 0;
  virtual void SleepFor(Duration duration) = 0;
};

// The real clock. Thread safe.
class SystemClock final : public Clock {
 public:
  TimePoint Now() const override;
  void SleepFor(Duration duration) override;
};

// A clock that moves only when told: for tests. SleepFor advances it. Not thread safe.
class ManualClock final : public Clock {
 public:
  TimePoint Now() const override { return now_; }
  void SleepFor(Duration duration) override { now_ += duration; }
  void Advance(Duration duration) { now_ += duration; }

 private:
  TimePoint now_{};
};

// Nanoseconds since the Unix epoch: for stamps that cross processes.
int64_t WallTimeNs();

inline double ToSeconds(Duration duration) { return std::chrono::duration<double>(duration).count(); }
inline Duration FromSeconds(double seconds) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(seconds));
}

}  // namespace dadrl
