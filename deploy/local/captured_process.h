// A child process whose output and log are kept in memory until it is asked for.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/io/file_descriptor.h"
#include "common/util/result.h"
#include "deploy/local/child_process.h"
#include "deploy/local/liveness_watch.h"

namespace dadrl {

// Of each, output and log. An evaluation's worker prints half a kilobyte an episode, a thousand at most.
constexpr uint64_t kMaxCapturedBytes = uint64_t{64} << 20;

// Thread rule as ChildProcess.
class CapturedProcess {
 public:
  // `nice` is added to the child's niceness. Errors as ChildProcess::Spawn; kExhausted: no memory file.
  static Result<CapturedProcess> Spawn(std::vector<std::string> command, int nice = 0,
                                       const HangLimits& limits = {});

  ChildProcess& child() { return child_; }
  const ChildProcess& child() const { return child_; }

  // Whether the child has printed or logged more than kMaxCapturedBytes: it is none of ours, or has gone mad.
  // Its owner ends it.
  bool Overflows() const;
  // Why it is taken to hang, when it does (HangWatch); ask several times a second.
  std::optional<std::string> Hangs();

  // Standard output until now.
  std::string Output() const;
  // The whole lines of it, without line breaks.
  std::vector<std::string> OutputLines() const;
  int OutputLineCount() const;
  // The last lines of standard error.
  std::vector<std::string> LogEnd(size_t lines) const;
  // The message of the last line logged, without its stamp (common/util/log.h); empty when there is none.
  std::string LastMessage() const;

 private:
  CapturedProcess(ChildProcess child, LivenessWatch watch, FileDescriptor output, FileDescriptor log);

  ChildProcess child_;
  LivenessWatch watch_;
  FileDescriptor output_;
  FileDescriptor log_;
};

}  // namespace dadrl
