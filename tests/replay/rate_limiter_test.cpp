#include "replay/rate_limiter.h"

#include <gtest/gtest.h>

#include "common/util/random.h"

namespace dadrl {
namespace {

using Hold = RateLimiter::Hold;

TEST(RateLimiter, BlocksSamplingUntilTheMinimumSize) {
  RateLimiter limiter({.min_size = 100});
  EXPECT_EQ(limiter.MaySample(1, 0), Hold::kMinimumSize);
  EXPECT_EQ(limiter.MaySample(1, 99), Hold::kMinimumSize);
  EXPECT_EQ(limiter.MaySample(1, 100), Hold::kNone);
}

TEST(RateLimiter, WithoutRatiosOnlyTheMinimumSizeCounts) {
  RateLimiter limiter({.min_size = 1});
  limiter.OnInsert(1);
  limiter.OnSample(1000000);
  EXPECT_EQ(limiter.MaySample(1000000, 1), Hold::kNone);
  limiter.OnInsert(1000000000);
  EXPECT_TRUE(limiter.MayInsert(1000000000));
}

TEST(RateLimiter, SamplingStaysUnderItsMaximumPlusTheBand) {
  RateLimiter limiter({.min_size = 10, .max_samples_per_insert = 4.0, .band = 50.0});
  limiter.OnInsert(10);
  int64_t sampled = 0;
  for (int round = 0; round < 1000; ++round) {
    limiter.OnInsert(3);
    while (limiter.MaySample(8, 1000) == Hold::kNone) {
      limiter.OnSample(8);
      sampled += 8;
    }
    EXPECT_LE(sampled, 4 * limiter.state().inserted);
  }
  EXPECT_GE(sampled, 4 * limiter.state().inserted - 8);
}

TEST(RateLimiter, SamplingThatLaggedDoesNotSaveUpMoreThanTheBand) {
  RateLimiter limiter({.min_size = 1, .max_samples_per_insert = 2.0, .band = 100.0});
  limiter.OnInsert(1000000);
  int64_t sampled = 0;
  for (; limiter.MaySample(10, 1000) == Hold::kNone; sampled += 10) limiter.OnSample(10);
  EXPECT_EQ(sampled, 200);
}

TEST(RateLimiter, ABatchLargerThanTheBandIsServedOnceTheBandIsFull) {
  RateLimiter limiter({.min_size = 1, .max_samples_per_insert = 1.0, .band = 10.0});
  limiter.OnInsert(9);
  EXPECT_EQ(limiter.MaySample(64, 9), Hold::kSamplesPerInsert);
  limiter.OnInsert(1);
  EXPECT_EQ(limiter.MaySample(64, 10), Hold::kNone);
  limiter.OnSample(64);
  limiter.OnInsert(54);
  EXPECT_EQ(limiter.MaySample(64, 64), Hold::kSamplesPerInsert);
  limiter.OnInsert(10);
  EXPECT_EQ(limiter.MaySample(64, 74), Hold::kNone);
}

TEST(RateLimiter, HoldsInsertsBackWhenSamplingLagsAndLetsThemGoWhenItCatchesUp) {
  RateLimiter limiter({.min_size = 100, .min_samples_per_insert = 2.0, .band = 50.0});
  limiter.OnInsert(100);
  EXPECT_TRUE(limiter.MayInsert(100));  // the first min_size frames owe nothing
  limiter.OnInsert(50);
  EXPECT_TRUE(limiter.MayInsert(150));
  limiter.OnInsert(1);
  EXPECT_FALSE(limiter.MayInsert(151));
  limiter.OnSample(2);
  EXPECT_TRUE(limiter.MayInsert(151));
}

TEST(RateLimiter, InsertsAreFreeBelowTheMinimumSizeWhateverIsOwed) {
  RateLimiter limiter({.min_size = 100, .min_samples_per_insert = 1.0, .band = 1.0});
  limiter.OnInsert(1000);
  EXPECT_FALSE(limiter.MayInsert(1000));
  EXPECT_TRUE(limiter.MayInsert(99));
}

// Whatever the options and the batch: one side may always move.
TEST(RateLimiter, NeverHoldsBothSides) {
  Random random(1);
  for (int round = 0; round < 300; ++round) {
    const double max_ratio = random.Uniform(0.01, 20.0);
    RateLimiter limiter({.min_size = static_cast<int64_t>(1 + random.Below(500)),
                         .max_samples_per_insert = max_ratio,
                         .min_samples_per_insert = random.Uniform(0.0, max_ratio),
                         .band = random.Uniform(1.0, 300.0)});
    const auto batch = static_cast<int64_t>(1 + random.Below(256));
    const auto chunk = static_cast<int64_t>(1 + random.Below(2000));
    int64_t size = 0;
    for (int step = 0; step < 500; ++step) {
      const bool may_sample = limiter.MaySample(batch, size) == Hold::kNone;
      const bool may_insert = limiter.MayInsert(size);
      ASSERT_TRUE(may_sample || may_insert) << "round " << round << " step " << step;
      if (may_insert && (!may_sample || random.Uniform() < 0.5)) {
        limiter.OnInsert(chunk);
        size += chunk;
      } else {
        limiter.OnSample(batch);
      }
      if (random.Uniform() < 0.02) size = static_cast<int64_t>(random.Below(static_cast<uint64_t>(size + 1)));
    }
  }
}

TEST(RateLimiter, ANewBandHoldsAtOnce) {
  RateLimiter limiter({.min_size = 1, .max_samples_per_insert = 1.0, .band = 1000.0});
  limiter.OnInsert(1000);
  limiter.Reconfigure({.min_size = 1, .max_samples_per_insert = 1.0, .band = 10.0});
  limiter.OnSample(10);
  EXPECT_EQ(limiter.MaySample(1, 1000), Hold::kSamplesPerInsert);
  limiter.Reconfigure({.min_size = 1});
  EXPECT_EQ(limiter.MaySample(1, 1000), Hold::kNone);
}

}  // namespace
}  // namespace dadrl
