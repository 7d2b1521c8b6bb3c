#include "replay/service/limit_command.h"

#include <string_view>

namespace dadrl {
namespace {

// Below `least` the bound stays as it is; so it does for a NaN.
Status Set(std::string_view name, double wanted, double least, double most, double& value) {
  if (wanted > most) {
    return Fail(ErrorCode::kInvalidArgument, "{}: {:g} is not between {:g} and {:g}", name, wanted, least,
                most);
  }
  if (wanted >= least) value = wanted;
  return {};
}

}  // namespace

Result<RateLimiter::Options> ChangedLimits(const RateLimiter::Options& now,
                                           const dadrl_idl_ReplayCommand& command) {
  RateLimiter::Options options = now;
  if (command.min_size > RateLimiter::kMostMinSize) {
    return Fail(ErrorCode::kInvalidArgument, "min size: {} is not between 1 and {}", command.min_size,
                RateLimiter::kMostMinSize);
  }
  if (command.min_size >= 1) options.min_size = command.min_size;
  constexpr double kMost = RateLimiter::kMostSamplesPerInsert;
  DADRL_RETURN_IF_ERROR(
      Set("samples per insert", command.samples_per_insert, 0.0, kMost, options.max_samples_per_insert));
  DADRL_RETURN_IF_ERROR(Set("min samples per insert", command.min_samples_per_insert, 0.0, kMost,
                            options.min_samples_per_insert));
  DADRL_RETURN_IF_ERROR(Set("band", command.band_frames, 1.0, RateLimiter::kLongestBand, options.band));
  if (options.max_samples_per_insert > 0.0 &&
      options.min_samples_per_insert > options.max_samples_per_insert) {
    return Fail(ErrorCode::kInvalidArgument,
                "at least {} and at most {} samples per insert: both sides would wait",
                options.min_samples_per_insert, options.max_samples_per_insert);
  }
  return options;
}

}  // namespace dadrl
