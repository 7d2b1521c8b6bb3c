#include "learner/trainer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <set>

#include "common/model/policy_file.h"
#include "tests/common/io/temporary_folder.h"
#include "tests/learner/fake_algorithm.h"
#include "tests/learner/test_learner.h"

namespace dadrl {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;

class TrainerTest : public testing::Test {
 protected:
  Config config_;
  TemporaryFolder folder_;
};

TEST_F(TrainerTest, ResumedTrainingEqualsAnUninterruptedOneBitForBit) {
  constexpr int kUpdates = 25;
  TemporaryFolder other;
  TestLearner whole(config_, other.path(), false);
  whole.Steps(2 * kUpdates);
  {
    TestLearner first(config_, folder_.path(), false);
    first.Steps(kUpdates);
    ASSERT_TRUE(first.trainer->SaveNow());
  }
  TestLearner second(config_, folder_.path(), true, kUpdates);
  ASSERT_TRUE(second.trainer) << second.error.message;
  second.Steps(kUpdates);
  EXPECT_EQ(StateOf(*second.algorithm), StateOf(*whole.algorithm));
  EXPECT_EQ(second.trainer->TakeInterval().updates, static_cast<uint64_t>(2 * kUpdates));
}

TEST_F(TrainerTest, PublishesFirstAfterTheFirstUpdateThenEachInterval) {
  config_.learner.publish_interval_s = 1.0;
  TestLearner run(config_, folder_.path(), false);
  run.batches.available = 0;
  ASSERT_EQ(run.trainer->RunStep(Duration::zero()).value(), Trainer::Step::kNoBatch);
  EXPECT_TRUE(run.publisher.versions.empty());
  run.batches.available = 1000;
  for (int i = 0; i < 20; ++i) {
    run.Steps(1);
    run.clock.Advance(100ms);
  }
  EXPECT_THAT(run.publisher.versions, ElementsAre(1, 2));
}

TEST_F(TrainerTest, ResumedRunPublishesAtOnceAboveEveryUsedVersion) {
  {
    TestLearner first(config_, folder_.path(), false);
    first.Steps(3);
    ASSERT_TRUE(first.trainer->SaveNow());
  }
  TestLearner second(config_, folder_.path(), true);
  second.batches.available = 0;
  ASSERT_TRUE(second.trainer->RunStep(Duration::zero()));
  EXPECT_THAT(second.publisher.versions, ElementsAre(2));

  FakeAlgorithm algorithm;
  CheckpointStore store = CheckpointStore::Open(folder_.path(), {.checkpoints = 3, .policies = 3}).value();
  EXPECT_EQ(BeginTraining(config_, store, 16, true, algorithm)->weights_version, 16u);
}

// Ends the training that `spoil` makes fail in update 4 of it, an hour after the checkpoint at update 3.
class FailingTrainerTest : public TrainerTest {
 protected:
  template <typename Spoil>
  std::string EndOf(Spoil spoil) {
    config_.learner.publish_interval_s = 0.01;
    TestLearner run(config_, folder_.path(), false);
    spoil(run.fake());
    run.Steps(3);
    EXPECT_TRUE(run.trainer->SaveNow());
    const size_t published = run.publisher.versions.size();
    run.clock.Advance(1h);
    const std::atomic<bool> stop{false};
    const auto ended = run.trainer->Run(stop);
    EXPECT_EQ(run.publisher.versions.size(), published);
    EXPECT_EQ(run.batches.lent, 0);
    EXPECT_EQ(CheckpointStore::Open(folder_.path(), {.checkpoints = 3, .policies = 3})
                  ->LoadNewest()
                  .value()
                  ->checkpoint.updates,
              3u);
    EXPECT_FALSE(ended);
    if (ended) return "";
    EXPECT_EQ(ended.error().code, ErrorCode::kInternal);
    return ended.error().message;
  }
};

TEST_F(FailingTrainerTest, UpdateThatFailsPublishesNothingAndKeepsTheLastCheckpoint) {
  EXPECT_THAT(EndOf([](FakeAlgorithm& fake) { fake.FailAt(4); }), HasSubstr("fit is not finite"));
}

TEST_F(FailingTrainerTest, LossesThatRunAwayDoTheSame) {
  EXPECT_THAT(EndOf([](FakeAlgorithm& fake) { fake.RunAwayAt(4); }),
              HasSubstr("the training has run away: in update 4 fit is 1e+57"));
}

TEST_F(TrainerTest, EndsWithTheReasonWhenNoBatchWillComeAnyMore) {
  TestLearner learner(config_, folder_.path(), false);
  learner.batches.available = 1;
  learner.batches.failure = Fail(ErrorCode::kInvalidArgument, "the replay is another one");
  const std::atomic<bool> never{false};
  const auto ended = learner.trainer->Run(never);
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().message, "the replay is another one");
  EXPECT_EQ(learner.trainer->TakeInterval().updates, 1u);
}

TEST_F(TrainerTest, PolicyThatIsNotFiniteIsNeitherPublishedNorSaved) {
  TestLearner run(config_, folder_.path(), false);
  run.Steps(1);
  run.fake().SpoilPolicy();
  run.clock.Advance(1h);
  const auto step = run.trainer->RunStep(Duration::zero());
  ASSERT_FALSE(step);
  EXPECT_THAT(step.error().message, HasSubstr("parameter 7 of the policy is not finite"));
  EXPECT_EQ(run.publisher.versions.size(), 1u);
  EXPECT_FALSE(run.trainer->SaveNow());
  EXPECT_TRUE(CheckpointStore::Open(folder_.path(), {.checkpoints = 3, .policies = 3})->empty());
}

TEST_F(TrainerTest, CheckpointsEachIntervalWithoutStoppingTheTraining) {
  config_.learner.checkpoint_interval_s = 30.0;
  TestLearner run(config_, folder_.path(), false);
  const TimePoint began = run.clock.Now();
  std::set<std::optional<TimePoint>> saved_at;
  for (int i = 0; i < 7; ++i) {
    run.Steps(1);
    ASSERT_TRUE(run.checkpoints->Finish());  // the clock of the test may not move under the writer
    saved_at.insert(run.checkpoints->saved_at());
    run.clock.Advance(10s);
  }
  EXPECT_THAT(saved_at, testing::ElementsAre(std::nullopt, began + 30s, began + 60s));
  auto store = CheckpointStore::Open(folder_.path(), {.checkpoints = 3, .policies = 3});
  EXPECT_EQ(store->LoadNewest()->value().checkpoint.updates, 7u);
}

TEST_F(TrainerTest, StopsAtMaxUpdatesWithACheckpointAndStaysThereWhenResumed) {
  config_.learner.max_updates = 12;
  const std::atomic<bool> stop{false};
  {
    TestLearner run(config_, folder_.path(), false);
    const auto ended = run.trainer->Run(stop);
    ASSERT_TRUE(ended) << ended.error().message;
    EXPECT_THAT(*ended, HasSubstr("max_updates of 12"));
  }
  EXPECT_EQ(LoadPolicy(folder_.path() / "latest")->updates, 12u);
  TestLearner again(config_, folder_.path(), true);
  ASSERT_TRUE(again.trainer->Run(stop));
  EXPECT_EQ(again.trainer->TakeInterval().updates, 12u);
}

TEST_F(TrainerTest, StopsWhenAskedWhileItWaitsForExperience) {
  TestLearner run(config_, folder_.path(), false);
  run.batches.available = 0;
  const std::atomic<bool> stop{true};
  const auto ended = run.trainer->Run(stop);
  ASSERT_TRUE(ended);
  EXPECT_THAT(*ended, HasSubstr("asked to stop after 0 updates"));
}

TEST_F(TrainerTest, MinutesCountOverRestarts) {
  config_.minutes = 1.0;
  const std::atomic<bool> stop{false};
  {
    TestLearner first(config_, folder_.path(), false);
    first.clock.Advance(59s);
    first.Steps(1);
    ASSERT_TRUE(first.trainer->SaveNow());
  }
  TestLearner second(config_, folder_.path(), true);
  second.clock.Advance(2s);
  EXPECT_THAT(second.trainer->Run(stop).value(), HasSubstr("minutes of 1 reached"));
}

// What a training computes, of the tests below: half a second an update.
Duration computed{};
Duration Computed() { return computed; }

TEST_F(TrainerTest, StopsAtItsProcessorTimeWhichCountsOverRestartsAndNotWhileItWaits) {
  config_.learner.max_cpu_seconds = 10.0;
  const auto step = [](TestLearner& run) {
    run.Steps(1);
    computed += 500ms;
  };
  computed = 3h;  // of the process before it began
  const std::atomic<bool> stop{false};
  {
    TestLearner first(config_, folder_.path(), false, 0, std::make_unique<FakeAlgorithm>(), Computed);
    first.clock.Advance(1h);
    for (int i = 0; i < 19; ++i) step(first);
    EXPECT_DOUBLE_EQ(first.trainer->TakeInterval().cpu_s, 9.5);
    ASSERT_TRUE(first.trainer->SaveNow());
    step(first);  // lost with the process
  }
  computed = 0s;
  TestLearner second(config_, folder_.path(), true, 19, std::make_unique<FakeAlgorithm>(), Computed);
  EXPECT_DOUBLE_EQ(second.trainer->TakeInterval().cpu_s, 9.5);
  step(second);
  EXPECT_THAT(second.trainer->Run(stop).value(),
              HasSubstr("learner.max_cpu_seconds of 10 reached after 20 updates"));
  TestLearner third(config_, folder_.path(), true, 20, std::make_unique<FakeAlgorithm>(), Computed);
  EXPECT_THAT(third.trainer->Run(stop).value(), HasSubstr("after 20 updates"));
}

TEST_F(TrainerTest, ReportsWhatItWaitsForAndHowStaleTheExperienceIs) {
  config_.learner.publish_interval_s = 0.01;
  TestLearner run(config_, folder_.path(), false);
  for (int i = 0; i < 5; ++i) {
    run.Steps(1);
    run.clock.Advance(20ms);
  }
  run.trainer->TakeInterval();
  run.batches.acting_version = 2;
  run.Steps(1);
  const TrainingInterval interval = run.trainer->TakeInterval();
  EXPECT_EQ(interval.interval_updates, 1u);
  EXPECT_DOUBLE_EQ(interval.staleness.versions_max, 3.0);
  EXPECT_GT(interval.scalars[0], 0.0);
  run.batches.available = 0;
  ASSERT_EQ(run.trainer->RunStep(Duration::zero()).value(), Trainer::Step::kNoBatch);
  run.clock.Advance(3s);
  EXPECT_DOUBLE_EQ(run.trainer->ledger().Read()[Activity::kWaitForInserts].seconds, 3.0);
}

TEST_F(TrainerTest, ReturnsPrioritiesOnlyToAPrioritisedSampler) {
  {
    TestLearner run(config_, folder_.path(), false);
    run.Steps(1);
    EXPECT_TRUE(run.batches.priorities.empty());
  }
  config_.replay.sampler = SamplerKind::kPrioritized;
  TestLearner run(config_, folder_.path(), false);
  run.Steps(2);
  EXPECT_THAT(run.batches.priorities, testing::Each(2.0f));
  EXPECT_EQ(run.batches.priorities.size(), 16u);
}

TEST_F(TrainerTest, ReturnsNoPrioritiesOfAnAlgorithmThatGivesNone) {
  config_.replay.sampler = SamplerKind::kPrioritized;
  auto algorithm = std::make_unique<FakeAlgorithm>();
  algorithm->GiveNoPriorities();
  TestLearner run(config_, folder_.path(), false, 0, std::move(algorithm));
  run.batches.priorities = {7.0f};
  run.Steps(1);
  EXPECT_THAT(run.batches.priorities, ElementsAre(7.0f));
}

TEST_F(TrainerTest, MeansAreOfTheUpdatesThatGaveTheScalar) {
  TestLearner run(config_, folder_.path(), false);
  run.Steps(1);
  EXPECT_TRUE(std::isnan(run.trainer->TakeInterval().scalars[1]));
  run.Steps(4);  // updates 2 to 5 give 2 and 4
  EXPECT_DOUBLE_EQ(run.trainer->TakeInterval().scalars[1], 3.0);
  EXPECT_TRUE(std::isnan(run.trainer->TakeInterval().scalars[0]));
}

TEST_F(TrainerTest, PublishesBeforeTheFirstUpdateWhereTheAlgorithmActsFromTheStart) {
  auto algorithm = std::make_unique<FakeAlgorithm>();
  algorithm->ActFromStart();
  TestLearner run(config_, folder_.path(), false, 0, std::move(algorithm));
  run.batches.available = 0;
  ASSERT_EQ(run.trainer->RunStep(Duration::zero()).value(), Trainer::Step::kNoBatch);
  EXPECT_THAT(run.publisher.versions, ElementsAre(1));
}

TEST_F(TrainerTest, NewTrainingRefusesAFolderWithCheckpoints) {
  {
    TestLearner first(config_, folder_.path(), false);
    ASSERT_TRUE(first.trainer->SaveNow());
  }
  TestLearner second(config_, folder_.path(), false);
  EXPECT_EQ(second.error.code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(second.error.message, HasSubstr("--resume"));
}

TEST_F(TrainerTest, ResumeWithOtherNetworksNamesTheKeys) {
  {
    TestLearner first(config_, folder_.path(), false);
    ASSERT_TRUE(first.trainer->SaveNow());
  }
  config_.model.hidden = 64;
  TestLearner second(config_, folder_.path(), true);
  EXPECT_EQ(second.error.code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(second.error.message, HasSubstr("model.hidden (there 256, now 64)"));
}

TEST_F(TrainerTest, ResumeWithoutACheckpointBeginsAboveTheReservedVersions) {
  FakeAlgorithm algorithm;
  CheckpointStore store = CheckpointStore::Open(folder_.path(), {.checkpoints = 3, .policies = 3}).value();
  const auto progress = BeginTraining(config_, store, 16, true, algorithm);
  ASSERT_TRUE(progress);
  EXPECT_EQ(progress->updates, 0u);
  EXPECT_EQ(progress->weights_version, 16u);
}

}  // namespace
}  // namespace dadrl
