// How a thread that works says that it gets on. Free where nobody supervises the process: lockstep, tools.
#pragma once

#include <cstdint>
#include <string_view>

#include "common/liveness/beat_page.h"
#include "common/util/clock.h"

namespace dadrl {

// While it lives, the calling thread is one whose silence means that the process hangs: it must call Beat at
// least once a second, also while it waits. Belongs to that thread. Beyond BeatMemory::kThreads at once,
// threads are not watched.
class WorkingThread {
 public:
  // `name`: what the supervisor calls it ("train"), cut to 23 characters.
  explicit WorkingThread(std::string_view name);
  ~WorkingThread();
  WorkingThread(const WorkingThread&) = delete;
  WorkingThread& operator=(const WorkingThread&) = delete;

 private:
  BeatRecord* record_;
  BeatRecord* const outer_;  // of a WorkingThread around this one
};

// The calling thread got round its loop. Costs nanoseconds; nothing for a thread that is no WorkingThread.
void Beat();

// While it lives, the calling thread may be silent for `limit`: for work that cannot beat, such as a write to
// a slow disk. Beats at both ends.
class LongWork {
 public:
  explicit LongWork(Duration limit);
  ~LongWork();
  LongWork(const LongWork&) = delete;
  LongWork& operator=(const LongWork&) = delete;

 protected:
  explicit LongWork(uint32_t limit_ms);

 private:
  const uint32_t outer_limit_ms_;
};

// While it lives, the calling thread waits for its turn after another WorkingThread, and is not to blame.
class Resting : public LongWork {
 public:
  Resting() : LongWork(BeatRecord::kResting) {}
};

// What the process came to so far (updates, frames): for the supervisor, which believes no network. Any
// thread.
void ReportWork(uint64_t total);

// What holds this process up, in one line ("cannot store experience: no space left on device"), or that
// nothing does any more (empty). It is shown where people look, and its time counts as lost
// (deploy/local/lost_time.h). Any thread; cut to 155 characters.
void ReportFault(std::string_view what);

// How long the supervisor has kept this process stopped since it began (Ctrl-Z): no time of its work.
Duration PausedTime();

}  // namespace dadrl
