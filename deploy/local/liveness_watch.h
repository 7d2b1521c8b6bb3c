// Watches over one child process: the page on which it beats, and whether it hangs.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "common/liveness/beat_page.h"
#include "deploy/local/hang_watch.h"

namespace dadrl {

// One start of the process. Not thread safe; nothing blocks.
class LivenessWatch {
 public:
  // Made before the process starts: it inherits page_fd. Without memory for a page it watches nothing.
  LivenessWatch(const HangLimits& limits, TimePoint now);

  int page_fd() const { return page_ ? page_->fd() : -1; }
  // Why `process` is taken to hang; looks a few times a second, however often it is called.
  std::optional<std::string> Look(pid_t process, TimePoint now);

  // A thread of it works or has worked: it came up.
  bool begun() const { return watch_.begun(); }
  // As HangWatch::Suspicion.
  std::string Suspicion() const { return watch_.Suspicion(); }
  // What it says that it came to, and what holds it up (common/liveness/working_thread.h).
  uint64_t work() const { return page_ ? page_->work() : 0; }
  std::string Fault() const { return page_ ? page_->Fault() : std::string(); }
  // It was kept stopped for so long, and not by its own fault.
  void AddPause(Duration paused);

 private:
  std::optional<BeatPage> page_;
  HangWatch watch_;
  TimePoint next_look_;
};

// Appends what each thread of `process` is at to `log`, and asks it for its stacks if it knows how
// (common/liveness/stack_dump.h); they are there a moment later. Best effort.
void DumpThreads(pid_t process, const std::filesystem::path& log);

}  // namespace dadrl
