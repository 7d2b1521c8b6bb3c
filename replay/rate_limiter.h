// How fast experience may be sampled in proportion to how fast it comes in, and the other way round.
//
// Two independent bounds, each a bucket, so that neither remembers more than its band:
//  - sampling may not run ahead: each inserted frame earns `max_samples_per_insert` samples, at most `band`
//    frames' worth are saved up. (Without the cap, an hour of fast actors would later allow an hour of
//    training on what has gone stale.) 0: no bound.
//  - inserting may not run ahead: each inserted frame after the first `min_size` owes
//  `min_samples_per_insert`
//    samples; more than `band` frames' worth of debt hold inserts back. 0, the default: actors are never held
//    back, since fresh and plentiful experience helps off-policy learning, and the oldest is dropped first.
//
// Never a deadlock: below `min_size` inserts are always allowed, and whenever sampling has to wait for
// inserts, inserts are allowed whatever the debt.
#pragma once

#include <cstdint>

namespace dadrl {

// Not thread safe.
class RateLimiter {
 public:
  struct Options {
    int64_t min_size = 1;  // sampleable items before the first sample
    double max_samples_per_insert = 0.0;
    double min_samples_per_insert = 0.0;
    double band = 1000.0;  // frames
    bool operator==(const Options&) const = default;
  };
  // Why sampling has to wait.
  enum class Hold { kNone, kMinimumSize, kSamplesPerInsert };
  // What a restart restores.
  struct State {
    int64_t inserted = 0;  // frames since the run began
    int64_t sampled = 0;   // transitions since the run began
    double sample_credit = 0.0;
    double insert_debt = 0.0;
  };

  // Bounds that a command may set; those of a configuration may have a longer band.
  static constexpr int64_t kMostMinSize = int64_t{1} << 50;
  static constexpr double kMostSamplesPerInsert = 1e6;
  static constexpr double kLongestBand = 1e12;

  // False for numbers that no limiter has had: with them both sides would wait for ever, or never.
  static bool IsPossible(const Options& options);
  static bool IsPossible(const State& state);

  explicit RateLimiter(const Options& options) : options_(options) {}

  // New bounds from now on. Credit is cut to the new band; debt has still to be paid.
  void Reconfigure(const Options& options);

  // May `count` transitions be sampled now, of `size` sampleable items? A request larger than the
  // band is served once the band is full.
  Hold MaySample(int64_t count, int64_t size);
  // May more frames come in? Advice for the senders: what arrives is stored.
  bool MayInsert(int64_t size) const;

  void OnInsert(int64_t frames);
  void OnSample(int64_t count);

  const Options& options() const { return options_; }
  const State& state() const { return state_; }
  void Restore(const State& state);

 private:
  double MaxCredit() const { return options_.band * options_.max_samples_per_insert; }
  bool SamplingOpen(int64_t count) const;

  Options options_;
  State state_;
  int64_t last_request_ = 1;
};

}  // namespace dadrl
