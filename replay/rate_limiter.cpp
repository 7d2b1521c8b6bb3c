#include "replay/rate_limiter.h"

#include <algorithm>
#include <cmath>

namespace dadrl {
namespace {

// Not a NaN either.
bool IsBetween(double value, double least, double most) { return value >= least && value <= most; }

// Frames and samples of a run; sums of two stay far from overflowing.
constexpr int64_t kMostCounted = int64_t{1} << 60;
// Of one request, which may be larger than the band.
constexpr double kMostOverdraft = 1e9;

}  // namespace

bool RateLimiter::IsPossible(const Options& options) {
  return options.min_size >= 1 && options.min_size <= kMostMinSize &&
         IsBetween(options.max_samples_per_insert, 0.0, kMostSamplesPerInsert) &&
         IsBetween(options.min_samples_per_insert, 0.0, kMostSamplesPerInsert) &&
         std::isfinite(options.band) && options.band >= 1.0;
}

bool RateLimiter::IsPossible(const State& state) {
  return state.inserted >= 0 && state.inserted <= kMostCounted && state.sampled >= 0 &&
         state.sampled <= kMostCounted && std::isfinite(state.sample_credit) &&
         state.sample_credit >= -kMostOverdraft && std::isfinite(state.insert_debt) &&
         state.insert_debt >= 0.0;
}

void RateLimiter::Reconfigure(const Options& options) {
  options_ = options;
  Restore(state_);
}

void RateLimiter::Restore(const State& state) {
  state_ = state;
  state_.sample_credit = std::min(state_.sample_credit, MaxCredit());
}

bool RateLimiter::SamplingOpen(int64_t count) const {
  if (options_.max_samples_per_insert <= 0.0) return true;
  return state_.sample_credit >= std::min<double>(count, MaxCredit());
}

RateLimiter::Hold RateLimiter::MaySample(int64_t count, int64_t size) {
  last_request_ = count;
  if (size < std::max<int64_t>(options_.min_size, 1)) return Hold::kMinimumSize;
  return SamplingOpen(count) ? Hold::kNone : Hold::kSamplesPerInsert;
}

bool RateLimiter::MayInsert(int64_t size) const {
  const double max_debt = options_.band * options_.min_samples_per_insert;
  return options_.min_samples_per_insert <= 0.0 || state_.insert_debt <= max_debt ||
         size < std::max<int64_t>(options_.min_size, 1) || !SamplingOpen(last_request_);
}

void RateLimiter::OnInsert(int64_t frames) {
  const int64_t before = std::max(state_.inserted, options_.min_size);
  state_.inserted += frames;
  const double owing = std::max<int64_t>(state_.inserted - before, 0);
  state_.insert_debt += owing * options_.min_samples_per_insert;
  const double earned = frames * options_.max_samples_per_insert;
  state_.sample_credit = std::min(state_.sample_credit + earned, MaxCredit());
}

void RateLimiter::OnSample(int64_t count) {
  const double samples = count;
  state_.sampled += count;
  if (options_.max_samples_per_insert > 0.0) state_.sample_credit -= samples;
  // Sampling more than was owed is not saved up either.
  state_.insert_debt = std::max(state_.insert_debt - samples, 0.0);
}

}  // namespace dadrl
