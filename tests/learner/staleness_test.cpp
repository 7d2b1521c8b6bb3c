#include "learner/staleness.h"

#include <gtest/gtest.h>

#include <vector>

namespace dadrl {
namespace {

constexpr int64_t kSecond = 1'000'000'000;

TEST(Staleness, CountsVersionsAndTheSecondsBetweenTheirPublications) {
  StalenessTracker tracker(0, {});
  for (uint32_t version = 1; version <= 5; ++version) tracker.OnPublish(version, version * 2 * kSecond);
  tracker.Add(std::vector<uint32_t>{5, 4, 2, 1});
  const Staleness staleness = tracker.TakeInterval();
  EXPECT_DOUBLE_EQ(staleness.versions_mean, (0 + 1 + 3 + 4) / 4.0);
  EXPECT_DOUBLE_EQ(staleness.versions_max, 4.0);
  EXPECT_DOUBLE_EQ(staleness.seconds_mean, 2.0 * (0 + 1 + 3 + 4) / 4.0);
  EXPECT_DOUBLE_EQ(staleness.seconds_max, 8.0);
}

TEST(Staleness, EachIntervalStartsAnew) {
  StalenessTracker tracker(0, {});
  tracker.OnPublish(3, kSecond);
  tracker.Add(std::vector<uint32_t>{1});
  EXPECT_DOUBLE_EQ(tracker.TakeInterval().versions_max, 2.0);
  EXPECT_DOUBLE_EQ(tracker.TakeInterval().versions_max, 0.0);
}

TEST(Staleness, RemembersPublicationsOverARestartAndSkippedVersions) {
  StalenessTracker before(0, {});
  before.OnPublish(1, 10 * kSecond);
  before.OnPublish(2, 12 * kSecond);
  StalenessTracker after(before.newest(), before.published_ns());
  after.OnPublish(18, 20 * kSecond);
  after.Add(std::vector<uint32_t>{1});
  const Staleness staleness = after.TakeInterval();
  EXPECT_DOUBLE_EQ(staleness.versions_max, 17.0);
  EXPECT_DOUBLE_EQ(staleness.seconds_max, 10.0);
}

TEST(Staleness, NewerThanTheNewestAndOlderThanMemoryAreClamped) {
  StalenessTracker tracker(0, {});
  for (uint32_t version = 1; version <= 5000; ++version) tracker.OnPublish(version, version * kSecond);
  tracker.Add(std::vector<uint32_t>{6000});
  EXPECT_DOUBLE_EQ(tracker.TakeInterval().seconds_max, 0.0);
  tracker.Add(std::vector<uint32_t>{0});
  const Staleness staleness = tracker.TakeInterval();
  EXPECT_DOUBLE_EQ(staleness.versions_max, 5000.0);
  EXPECT_DOUBLE_EQ(staleness.seconds_max, 4095.0);
}

}  // namespace
}  // namespace dadrl
