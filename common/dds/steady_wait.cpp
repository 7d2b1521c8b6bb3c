#include "common/dds/steady_wait.h"

#include <pthread.h>

#include <algorithm>
#include <cstdint>
#include <ctime>

#if defined(__has_feature)
#define DADRL_HAS_FEATURE(x) __has_feature(x)
#else
#define DADRL_HAS_FEATURE(x) 0
#endif
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__) || DADRL_HAS_FEATURE(thread_sanitizer) || \
    DADRL_HAS_FEATURE(address_sanitizer)
#define DADRL_SANITIZED
#endif

#ifndef DADRL_SANITIZED
namespace {

constexpr int64_t kSecond = 1'000'000'000;

int64_t Nanoseconds(const timespec& time) { return int64_t{time.tv_sec} * kSecond + time.tv_nsec; }

int64_t Now(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return Nanoseconds(now);
}

}  // namespace

// Takes the place of the system's function of this name: a definition in the program comes first.
extern "C" int pthread_cond_timedwait(pthread_cond_t* condition, pthread_mutex_t* mutex,
                                      const timespec* until) {
  const int64_t left = std::max<int64_t>(0, Nanoseconds(*until) - Now(CLOCK_REALTIME));
  const int64_t end = Now(CLOCK_MONOTONIC) + left;
  const timespec steady{.tv_sec = end / kSecond, .tv_nsec = end % kSecond};
  return pthread_cond_clockwait(condition, mutex, CLOCK_MONOTONIC, &steady);
}
#endif

namespace dadrl::dds {

// The call alone brings the definition above into the program.
void WaitSteadily() {}

}  // namespace dadrl::dds
