// A process as the supervisor's tests want it. `test_worker beat FILE`: works until it is asked to end;
// `test_worker deadlock FILE`: works for a moment, then its thread waits for ever. FILE gets its pid.
#include <unistd.h>

#include <fstream>
#include <string_view>

#include "common/liveness/stack_dump.h"
#include "common/liveness/working_thread.h"
#include "common/util/shutdown.h"

// Found by its name in a dump: not inlined, with linkage.
__attribute__((noinline)) void WaitForEver() {
  for (;;) pause();
}

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  dadrl::InstallShutdownHandler();
  dadrl::InstallStackDump();
  const dadrl::WorkingThread working("work");
  dadrl::ReportWork(7);
  dadrl::ReportFault("cannot store experience");
  std::ofstream(argv[2]) << getpid();
  if (argv[1] == std::string_view("deadlock")) WaitForEver();
  while (!dadrl::shutdown_requested) {
    dadrl::Beat();
    usleep(10'000);
  }
  return 0;
}
