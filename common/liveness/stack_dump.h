// The stack of a thread that hangs, in the log of its process.
#pragma once

namespace dadrl {

// The signal that asks a thread for its stack: sent by the supervisor to each thread of a process that hangs.
int StackDumpSignal();

// From now on a thread that gets StackDumpSignal writes its stack to standard error, with calls that are safe
// in a signal handler. Addresses are of the program file: `addr2line -Cfe PROGRAM ADDRESS` names lines.
void InstallStackDump();

}  // namespace dadrl
