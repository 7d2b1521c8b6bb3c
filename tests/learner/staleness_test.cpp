#include "learner/staleness.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "common/step/driving_shape.h"

namespace dadrl {
namespace {

constexpr int64_t kSecond = 1'000'000'000;

// One step a trajectory.
TrajectoryBatch BatchOf(const std::vector<uint32_t>& versions) {
  TrajectoryBatch batch(DrivingShape{}, {.count = static_cast<int>(versions.size())});
  batch.policy_versions = versions;
  std::ranges::fill(batch.steps, 1);
  return batch;
}

TEST(Staleness, CountsVersionsAndTheSecondsBetweenTheirPublications) {
  StalenessTracker tracker(0, {});
  for (uint32_t version = 1; version <= 5; ++version) tracker.OnPublish(version, version * 2 * kSecond);
  tracker.Add(BatchOf({5, 4, 2, 1}));
  const Staleness staleness = tracker.TakeInterval();
  EXPECT_DOUBLE_EQ(staleness.versions_mean, (0 + 1 + 3 + 4) / 4.0);
  EXPECT_DOUBLE_EQ(staleness.versions_max, 4.0);
  EXPECT_DOUBLE_EQ(staleness.seconds_mean, 2.0 * (0 + 1 + 3 + 4) / 4.0);
  EXPECT_DOUBLE_EQ(staleness.seconds_max, 8.0);
}

TEST(Staleness, CountsEveryStepOfATrajectoryAndNothingBehindItsEnd) {
  StalenessTracker tracker(0, {});
  for (uint32_t version = 1; version <= 5; ++version) tracker.OnPublish(version, version * kSecond);
  TrajectoryBatch batch(DrivingShape{}, {.count = 2, .steps = 3, .all_observations = true});
  batch.policy_versions = {4, 5,  //
                           4, 0,  //
                           5, 0};
  batch.steps = {3, 1};
  tracker.Add(batch);
  const Staleness staleness = tracker.TakeInterval();
  EXPECT_DOUBLE_EQ(staleness.versions_mean, (1 + 1 + 0 + 0) / 4.0);
  EXPECT_DOUBLE_EQ(staleness.versions_max, 1.0);
}

TEST(Staleness, EachIntervalStartsAnew) {
  StalenessTracker tracker(0, {});
  tracker.OnPublish(3, kSecond);
  tracker.Add(BatchOf({1}));
  EXPECT_DOUBLE_EQ(tracker.TakeInterval().versions_max, 2.0);
  EXPECT_DOUBLE_EQ(tracker.TakeInterval().versions_max, 0.0);
}

TEST(Staleness, RemembersPublicationsOverARestartAndSkippedVersions) {
  StalenessTracker before(0, {});
  before.OnPublish(1, 10 * kSecond);
  before.OnPublish(2, 12 * kSecond);
  StalenessTracker after(before.newest(), before.published_ns());
  after.OnPublish(18, 20 * kSecond);
  after.Add(BatchOf({1}));
  const Staleness staleness = after.TakeInterval();
  EXPECT_DOUBLE_EQ(staleness.versions_max, 17.0);
  EXPECT_DOUBLE_EQ(staleness.seconds_max, 10.0);
}

TEST(Staleness, NewerThanTheNewestAndOlderThanMemoryAreClamped) {
  StalenessTracker tracker(0, {});
  for (uint32_t version = 1; version <= 5000; ++version) tracker.OnPublish(version, version * kSecond);
  tracker.Add(BatchOf({6000}));
  EXPECT_DOUBLE_EQ(tracker.TakeInterval().seconds_max, 0.0);
  tracker.Add(BatchOf({0}));
  const Staleness staleness = tracker.TakeInterval();
  EXPECT_DOUBLE_EQ(staleness.versions_max, 5000.0);
  EXPECT_DOUBLE_EQ(staleness.seconds_max, 4095.0);
}

}  // namespace
}  // namespace dadrl
