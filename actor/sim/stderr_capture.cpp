#include "actor/sim/stderr_capture.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

namespace dadrl {

Result<StderrCapture> StderrCapture::Start() {
  DADRL_ASSIGN_OR_RETURN(MemoryFile file, MemoryFile::Create("dadrl-stderr"));
  std::fflush(stderr);
  const int original = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 0);
  const int capture = open(file.path().c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  if (original < 0 || capture < 0 || dup2(capture, STDERR_FILENO) < 0) {
    const std::string reason = std::strerror(errno);
    if (original >= 0) close(original);
    if (capture >= 0) close(capture);
    return Fail(ErrorCode::kExhausted, "cannot redirect standard error: {}", reason);
  }
  close(capture);
  return StderrCapture(std::move(file), original);
}

StderrCapture::~StderrCapture() { Restore(); }

void StderrCapture::Restore() {
  if (original_ < 0) return;
  std::fflush(stderr);
  dup2(original_, STDERR_FILENO);
  close(original_);
  original_ = -1;
}

std::string StderrCapture::Finish() {
  Restore();
  std::string text = file_.Read();
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

}  // namespace dadrl
