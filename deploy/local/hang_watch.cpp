#include "deploy/local/hang_watch.h"

#include <fmt/format.h>

#include <algorithm>

namespace dadrl {
namespace {

// More than this between two looks is a time in which this process did not run either.
constexpr Duration kLongestLook = std::chrono::seconds(1);
// Of the silence that is a hang: what makes us look closer, and what people are told of.
constexpr int kSuspicious = 5;
constexpr int kNotable = 2;

// How much of `interval` a thread wanted a core and had none; all of it when that was most of it. The kernel
// counts a wait when it is over: until then the thread's state says so.
Duration Starved(const ThreadTimes& now, const ThreadTimes& before, Duration interval) {
  Duration waited = now.waited - before.waited;
  if (now.state == 'R') waited = std::max(waited, interval - (now.ran - before.ran));
  return 2 * waited > interval ? interval : waited;
}

}  // namespace

HangLimits HangLimits::Of(const ClusterConfig& cluster) {
  constexpr Duration kShortest = std::chrono::seconds(1);  // working threads may wait for half of it
  HangLimits limits;
  limits.silent = std::max(kShortest, 5 * FromSeconds(cluster.liveliness_s));
  limits.spinning = limits.unborn = 12 * limits.silent;
  return limits;
}

Duration HangWatch::LimitOf(const BeatPage::Thread& thread) const {
  return thread.limit > Duration::zero() ? std::max(thread.limit, limits_.silent) : limits_.silent;
}

// Keeps the silence of a thread that has not beaten, begins that of one that has.
void HangWatch::TakeBeats(TimePoint now, const std::vector<BeatPage::Thread>& threads) {
  std::vector<Silence> silences;
  for (const BeatPage::Thread& thread : threads) {
    const auto known = std::find_if(silences_.begin(), silences_.end(), [&](const Silence& silence) {
      return silence.thread.id == thread.id && silence.thread.name == thread.name &&
             silence.thread.beats == thread.beats;
    });
    Silence& silence = silences.emplace_back(known == silences_.end() ? Silence{.since = now} : *known);
    silence.thread = thread;
  }
  silences_ = std::move(silences);
}

// Adds what the thread did in the last `interval`.
void HangWatch::Charge(Silence& silence, const std::vector<ThreadTimes>& times, Duration interval) const {
  Duration ran{};
  Duration excused{};
  for (const ThreadTimes& thread : times) {
    const auto before = before_.find(thread.id);
    if (before == before_.end()) continue;
    // Any thread may hold what ours waits for: one that waits for a device or a debugger excuses it.
    if (thread.state == 'D' || thread.state == 't') excused = interval;
    const bool own = thread.id == silence.thread.id || (silence.thread.id == 0 && &thread == &times.front());
    if (own) ran = thread.ran - before->second.ran;
    excused = std::max(excused, Starved(thread, before->second, interval) + (own ? ran : Duration::zero()));
  }
  silence.ran += ran;
  silence.idle += std::clamp<Duration>(interval - excused, Duration::zero(), kLongestLook);
}

std::optional<std::string> HangWatch::Look(TimePoint now, const std::vector<BeatPage::Thread>& threads,
                                           const ReadTimes& read_times) {
  begun_ = begun_ || !threads.empty();
  const BeatPage::Thread unborn{.id = 0, .limit = limits_.unborn};  // stands for the main thread
  TakeBeats(now, threads.empty() ? std::vector{unborn} : threads);
  const Duration interval = now - looked_;
  looked_ = now;
  const bool suspicious = std::any_of(silences_.begin(), silences_.end(), [&](const Silence& silence) {
    return now - silence.since >= limits_.silent / kSuspicious;
  });
  if (!suspicious) {
    before_.clear();
    stopped_ = {};
    return std::nullopt;
  }
  const std::vector<ThreadTimes> times = read_times();
  const bool stopped = !times.empty() && times.front().state == 'T';
  stopped_ = stopped ? stopped_ + std::min(interval, kLongestLook) : Duration::zero();
  if (!before_.empty() || times.empty()) {
    for (Silence& silence : silences_) Charge(silence, times, interval);
  }
  before_.clear();
  for (const ThreadTimes& thread : times) before_[thread.id] = thread;
  return Verdict();
}

std::optional<std::string> HangWatch::Verdict() const {
  if (stopped_ >= limits_.silent) return "it is stopped by a signal";
  for (const Silence& silence : silences_) {
    const BeatPage::Thread& thread = silence.thread;
    if (thread.resting) continue;
    if (silence.idle >= LimitOf(thread)) {
      if (thread.id == 0)
        return fmt::format("no thread of it has worked for {:.0f} s", ToSeconds(silence.idle));
      return fmt::format("its thread '{}' has been silent for {:.0f} s", thread.name,
                         ToSeconds(silence.idle));
    }
    if (silence.ran >= std::max(limits_.spinning, thread.limit)) {
      return fmt::format("its thread '{}' has computed for {:.0f} s without getting round its loop",
                         thread.name, ToSeconds(silence.ran));
    }
  }
  return std::nullopt;
}

std::string HangWatch::Suspicion() const {
  const auto notable = [](Duration silent, Duration limit) { return kNotable * silent >= limit; };
  if (kSuspicious * stopped_ >= limits_.silent) {
    return fmt::format("silent for {:.0f} s: stopped by a signal", ToSeconds(stopped_));
  }
  for (const Silence& silence : silences_) {
    if (silence.thread.resting || !notable(silence.idle, LimitOf(silence.thread))) continue;
    return silence.thread.id == 0 ? fmt::format("has not begun to work in {:.0f} s", ToSeconds(silence.idle))
                                  : fmt::format("silent for {:.0f} s: its thread '{}'",
                                                ToSeconds(silence.idle), silence.thread.name);
  }
  return {};
}

}  // namespace dadrl
