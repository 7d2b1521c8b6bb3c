// Reads what a library has to say only on standard error.
#pragma once

#include <string>

#include "actor/sim/memory_file.h"
#include "common/util/result.h"

namespace dadrl {

// From construction to Finish (or destruction) everything the process writes to standard error lands here;
// keep it short, and use it where no other thread has anything to say.
class StderrCapture {
 public:
  static Result<StderrCapture> Start();
  ~StderrCapture();
  StderrCapture(StderrCapture&& other) noexcept
      : file_(std::move(other.file_)), original_(std::exchange(other.original_, -1)) {}
  StderrCapture& operator=(StderrCapture&&) = delete;

  // Ends the capture and gives what was written, on one line.
  std::string Finish();

 private:
  StderrCapture(MemoryFile file, int original) : file_(std::move(file)), original_(original) {}
  void Restore();

  MemoryFile file_;
  int original_;  // descriptor of the true standard error; -1 once restored
};

}  // namespace dadrl
