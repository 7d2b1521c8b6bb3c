// What the threads of a process do, as the system sees it.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <vector>

#include "common/util/clock.h"

namespace dadrl {

struct ThreadTimes {
  pid_t id = 0;
  // R runs or waits for a core, S sleeps, D waits for a device, T is stopped by a signal, t by a debugger.
  char state = 'S';
  Duration ran{};     // on a core, since it began
  Duration waited{};  // for a core; zero where the kernel does not count that
};

// Of all threads of `process`, its main thread first; empty when it is gone, or cannot be looked into.
// Never blocks for long: /proc is no disk. `proc` is /proc but in tests.
std::vector<ThreadTimes> ReadThreadTimes(pid_t process, const std::filesystem::path& proc = "/proc");

}  // namespace dadrl
