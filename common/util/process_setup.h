// What every program of ours does before anything else.
#pragma once

#include <exception>
#include <string>

namespace dadrl {

// Takes all the descriptors that the host allows (the soft limit is raised to the hard one); lets a file that
// grows beyond its limit (ulimit -f) be an error of the write, not the end of the process; and lets no
// exception, of whatever thread, end the process without a sentence on standard error and exit code 1. Call
// at the start of main, before any thread.
void SetUpProcess();

// One line for a user: for std::bad_alloc what to do about it, otherwise what the exception says.
std::string ExceptionText(const std::exception& exception);

}  // namespace dadrl
