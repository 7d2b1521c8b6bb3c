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
  // Nanoseconds since the Unix epoch, for stamps that cross processes; may be set back.
  virtual int64_t WallTimeNs() const = 0;
  virtual void SleepFor(Duration duration) = 0;
};

// The real clock. Thread safe.
class SystemClock final : public Clock {
 public:
  TimePoint Now() const override;
  int64_t WallTimeNs() const override;
  void SleepFor(Duration duration) override;
};

// A clock that moves only when it is advanced, which SleepFor does too; its epoch is where it begins: for
// tests and deterministic trainings. Not thread safe.
class ManualClock final : public Clock {
 public:
  TimePoint Now() const override { return now_; }
  int64_t WallTimeNs() const override { return now_.time_since_epoch().count(); }
  void SleepFor(Duration duration) override { now_ += duration; }
  void Advance(Duration duration) { now_ += duration; }

 private:
  TimePoint now_{};
};

// That of the SystemClock, where no clock is at hand.
int64_t WallTimeNs();

// What this process has computed so far, all its threads together. Other load on the machine does not count,
// nor waiting.
Duration ProcessCpuTime();

inline double ToSeconds(Duration duration) { return std::chrono::duration<double>(duration).count(); }
inline Duration FromSeconds(double seconds) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(seconds));
}

}  // namespace dadrl
