// Decides whether a process hangs: from the beats of its working threads and from what the system says that
// they do. Pure: time and readings are passed in.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/liveness/beat_page.h"
#include "common/util/clock.h"
#include "deploy/local/thread_times.h"

namespace dadrl {

struct HangLimits {
  Duration silent = std::chrono::seconds(5);     // a working thread without a beat
  Duration spinning = std::chrono::seconds(60);  // one that computes all the while
  Duration unborn = std::chrono::seconds(60);    // while no thread has begun to work, or all have ended

  static HangLimits Of(const ClusterConfig& cluster);
};

// One process, from its start to its end. What counts as silence is time in which a thread could have beaten:
// not time in which it waited for a core (a busy machine), waited for a device (a slow disk), was held by a
// debugger, or in which nobody looked (this process was stopped, or the whole machine was). A process that
// was stopped by a signal is found whatever its threads were at. Not thread safe.
class HangWatch {
 public:
  using ReadTimes = std::function<std::vector<ThreadTimes>()>;

  HangWatch(const HangLimits& limits, TimePoint now) : limits_(limits), looked_(now) {}

  // To be called several times a second. `threads` as BeatPage::Threads; `read_times` is called only when one
  // of them is silent. Why the process is taken to hang: "it is stopped by a signal".
  std::optional<std::string> Look(TimePoint now, const std::vector<BeatPage::Thread>& threads,
                                  const ReadTimes& read_times);

  // What is suspicious before it is a hang: "silent for 3 s: stopped by a signal". Empty while all is well.
  std::string Suspicion() const;
  // A thread has begun to work, some time.
  bool begun() const { return begun_; }

 private:
  struct Silence {
    BeatPage::Thread thread;
    TimePoint since{};  // of its last beat
    Duration idle{};    // of that, what it could have used
    Duration ran{};
  };
  using TimesById = std::map<pid_t, ThreadTimes>;

  void TakeBeats(TimePoint now, const std::vector<BeatPage::Thread>& threads);
  void Charge(Silence& silence, const std::vector<ThreadTimes>& times, Duration interval) const;
  std::optional<std::string> Verdict() const;
  Duration LimitOf(const BeatPage::Thread& thread) const;

  HangLimits limits_;
  TimePoint looked_;
  bool begun_ = false;
  std::vector<Silence> silences_;
  TimesById before_;    // at the last look, if something was silent then
  Duration stopped_{};  // by a signal, up to now
};

}  // namespace dadrl
