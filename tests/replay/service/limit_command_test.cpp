#include "replay/service/limit_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace dadrl {
namespace {

using testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

dadrl_idl_ReplayCommand Nothing() {
  dadrl_idl_ReplayCommand command{};
  command.samples_per_insert = -1.0;
  command.min_samples_per_insert = -1.0;
  return command;
}

TEST(LimitCommand, ChangesWhatItNamesAndLeavesTheRest) {
  const RateLimiter::Options now{
      .min_size = 5, .max_samples_per_insert = 8.0, .min_samples_per_insert = 1.0, .band = 9.0};
  EXPECT_EQ(ChangedLimits(now, Nothing()), now);
  dadrl_idl_ReplayCommand command = Nothing();
  command.min_size = 7;
  command.samples_per_insert = 3.0;
  command.band_frames = 100.0;
  EXPECT_EQ(ChangedLimits(now, command),
            (RateLimiter::Options{
                .min_size = 7, .max_samples_per_insert = 3.0, .min_samples_per_insert = 1.0, .band = 100.0}));
}

TEST(LimitCommand, RefusesWhatWouldStopBothSidesForEver) {
  const auto refusal = [](auto set) {
    dadrl_idl_ReplayCommand command = Nothing();
    set(command);
    const auto changed = ChangedLimits({}, command);
    return changed ? std::string() : changed.error().message;
  };
  EXPECT_THAT(refusal([](auto& c) { c.min_size = std::numeric_limits<int64_t>::max(); }),
              HasSubstr("min size: 9223372036854775807 is not between 1 and"));
  EXPECT_THAT(refusal([](auto& c) { c.samples_per_insert = 1e300; }),
              HasSubstr("samples per insert: 1e+300 is not between 0 and 1e+06"));
  EXPECT_THAT(refusal([](auto& c) { c.min_samples_per_insert = kInfinity; }),
              HasSubstr("inf is not between"));
  EXPECT_THAT(refusal([](auto& c) { c.band_frames = kInfinity; }), HasSubstr("band: inf is not between"));
  EXPECT_THAT(refusal([](auto& c) {
                c.samples_per_insert = 1.0;
                c.min_samples_per_insert = 2.0;
              }),
              HasSubstr("both sides would wait"));
  EXPECT_EQ(refusal([](auto& c) { c.band_frames = std::nan(""); }), "");
}

}  // namespace
}  // namespace dadrl
