// Whether the host lets a process do what supervision is made of: a sandbox (seccomp) or an old kernel may
// not.
#pragma once

#include "deploy/local/machine_checks.h"

namespace dadrl {

// Tries each call and says what follows where one is refused. Changes nothing.
MachineCheck CheckSystemCalls();

}  // namespace dadrl
