#include "actor/collect/collector.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>

#include "proto/experience.h"
#include "tests/common/model/counting_policy.h"
#include "tests/driving_columns.h"

namespace dadrl {
namespace {

using ::testing::ElementsAre;

// A road on which nothing happens until the script says so. Observation number n of an episode holds n.
class ScriptedEnvironment final : public Environment {
 public:
  explicit ScriptedEnvironment(const DrivingShape& spec) : observation_(spec) {}

  int decisions = 3;       // of an episode
  bool terminates = true;  // else it is truncated
  Outcome end = Outcome::kSuccess;
  std::function<Status()> on_reset;
  std::function<Status()> on_step;
  std::vector<uint64_t> seeds;
  std::vector<Action> actions;

  Status Reset(uint64_t seed) override {
    seeds.push_back(seed);
    step_ = 0;
    EgoOf(observation_)[0] = 0.0f;
    return on_reset ? on_reset() : Status();
  }
  Result<StepResult> Step(const Action& action) override {
    if (on_step) DADRL_RETURN_IF_ERROR(on_step());
    actions.push_back(action);
    EgoOf(observation_)[0] = static_cast<float>(++step_);
    const bool last = step_ == decisions;
    summary_.seed = seeds.back();
    summary_.steps = 3 * step_ - 1;  // the last decision was cut short
    summary_.outcome = terminates ? end : Outcome::kStagnation;
    return StepResult{.reward = 10.0f * static_cast<float>(step_),
                      .terminated = last && terminates,
                      .truncated = last && !terminates};
  }
  const Observation& observation() const override { return observation_; }
  const EpisodeSummary& summary() const override { return summary_; }

 private:
  Observation observation_;
  EpisodeSummary summary_;
  int step_ = 0;
};

// Writes down what it is given: "begin 1", "0 r10 f0 v0", "final 3", "end".
class RecordingSink final : public ExperienceSink {
 public:
  std::vector<std::string> lines;
  std::function<bool()> is_blocked = [] { return false; };

  void BeginEpisode(uint64_t episode) override { lines.push_back(fmt::format("begin {}", episode)); }
  std::vector<std::vector<float>> decisions;

  void AddTransition(const Observation& observation, std::span<const float> decision, float reward,
                     uint8_t flags, uint32_t policy_version) override {
    decisions.emplace_back(decision.begin(), decision.end());
    lines.push_back(fmt::format("{} r{} f{} v{}", EgoOf(observation)[0], reward, flags, policy_version));
  }
  void AddFinal(const Observation& observation) override {
    lines.push_back(fmt::format("final {}", EgoOf(observation)[0]));
  }
  void EndEpisode() override { lines.emplace_back("end"); }
  bool blocked() const override { return is_blocked(); }
};

class ScriptedPolicies final : public PolicySource {
 public:
  uint32_t version = 0;
  std::vector<float> parameters;
  int looks = 0;
  std::function<void()> on_look = [] {};

  uint32_t TakeNewer(uint32_t have, std::vector<float>& out) override {
    ++looks;
    on_look();
    if (version <= have) return 0;
    out = parameters;
    return version;
  }
};

class CollectorTest : public ::testing::Test {
 protected:
  CollectorTest()
      : spec_(DrivingShape::From(config_.observation)),
        environment_(spec_),
        policy_(MakePolicyModel(spec_, config_.model).value()) {}
  Collector Make(uint64_t incarnation = 1) {
    return Collector(config_, {environment_, sink_, policies_, *policy_, ledger_, clock_, stop_}, 0,
                     incarnation);
  }
  void PublishPolicy(uint32_t version, float value = 0.01f) {
    policies_.version = version;
    policies_.parameters.assign(policy_->layout().size(), value);
  }

  Config config_;
  const DrivingShape spec_;
  ScriptedEnvironment environment_;
  RecordingSink sink_;
  ScriptedPolicies policies_;
  std::unique_ptr<PolicyModel> policy_;
  ManualClock clock_;
  TimeLedger ledger_{clock_};
  std::atomic<bool> stop_{false};
};

TEST_F(CollectorTest, GivesEachFrameTheActionTakenOnIt) {
  Collector collector = Make();
  const auto episode = collector.RunEpisode().value();
  ASSERT_TRUE(episode);
  EXPECT_THAT(sink_.lines, ElementsAre("begin 1", "0 r10 f0 v0", "1 r20 f0 v0", "2 r30 f10 v0", "end"));
  EXPECT_EQ(episode->episode, 1);
  EXPECT_EQ(episode->summary.seed, environment_.seeds[0]);
}

TEST_F(CollectorTest, GoesOnCountingAfterTheEpisodesOfAnEarlierStart) {
  Collector collector(config_, {environment_, sink_, policies_, *policy_, ledger_, clock_, stop_}, 0, 2, 41);
  EXPECT_EQ(collector.RunEpisode().value()->episode, 42u);
  EXPECT_THAT(sink_.lines, testing::Contains("begin 42"));
  EXPECT_EQ(collector.progress().episodes, 1u);  // since it began
}

TEST_F(CollectorTest, AddsTheObservationAfterATruncation) {
  environment_.terminates = false;
  Collector collector = Make();
  ASSERT_TRUE(collector.RunEpisode().value());
  EXPECT_THAT(sink_.lines,
              ElementsAre("begin 1", "0 r10 f0 v0", "1 r20 f0 v0", "2 r30 f4 v0", "final 3", "end"));
  EXPECT_EQ(collector.progress().outcomes[static_cast<size_t>(Outcome::kStagnation)], 1);
}

TEST_F(CollectorTest, MarksASuccessAndNoOtherEnd) {
  environment_.end = Outcome::kCollision;
  Collector collector = Make();
  ASSERT_TRUE(collector.RunEpisode().value());
  EXPECT_EQ(sink_.lines.at(3), "2 r30 f2 v0");
  environment_.end = Outcome::kSuccess;
  ASSERT_TRUE(collector.RunEpisode().value());
  EXPECT_EQ(sink_.lines.at(8), "2 r30 f10 v0");
}

TEST_F(CollectorTest, RecordsBesideTheActionWhatTheRunAsksFor) {
  config_.model.log_probability = true;
  Collector collector = Make();
  ASSERT_TRUE(collector.RunEpisode().value());
  for (const std::vector<float>& decision : sink_.decisions) {
    ASSERT_EQ(decision.size(), 3u);
    EXPECT_EQ(decision[2], 0.0f) << "random actions are held: they have no density";
  }
  PublishPolicy(1);
  ASSERT_TRUE(collector.RunEpisode().value());
  EXPECT_EQ(sink_.decisions.back()[2], *policy_->last().log_probability);
  EXPECT_EQ(sink_.decisions.back()[0], environment_.actions.back()[0]);
}

TEST_F(CollectorTest, CountsSimulationStepsExactly) {
  Collector collector = Make();
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(collector.RunEpisode().value());
  EXPECT_EQ(collector.progress().env_steps, 4 * 8);
  EXPECT_EQ(collector.progress().decisions, 4 * 3);
  EXPECT_EQ(collector.progress().episodes, 4);
}

TEST_F(CollectorTest, TakesANewPolicyInTheMiddleOfAnEpisode) {
  environment_.on_step = [&]() -> Status {
    if (environment_.actions.size() == 1) PublishPolicy(5);
    return {};
  };
  Collector collector = Make();
  const auto episode = collector.RunEpisode().value();
  EXPECT_THAT(sink_.lines, ElementsAre("begin 1", "0 r10 f0 v0", "1 r20 f0 v0", "2 r30 f10 v5", "end"));
  EXPECT_EQ(episode->policy_version, 5);
  EXPECT_EQ(collector.progress().policy_version, 5);
}

TEST_F(CollectorTest, WaitsForTheFirstPolicyWhereNothingButItsExperienceCounts) {
  config_.actor.wait_for_policy = true;
  Collector collector = Make();
  EXPECT_FALSE(collector.RunEpisode().value()) << "so that its owner can look why";
  EXPECT_TRUE(environment_.seeds.empty());
  EXPECT_TRUE(sink_.lines.empty());
  EXPECT_EQ(ledger_.Read()[Activity::kWaitForWeights].count, 1u);
  EXPECT_NEAR(ledger_.Read()[Activity::kWaitForWeights].seconds, 1.0, 0.01);
  policies_.on_look = [this] {
    if (policies_.looks == 150) PublishPolicy(3);
  };
  const auto episode = collector.RunEpisode().value();
  ASSERT_TRUE(episode);
  EXPECT_EQ(episode->episode, 1u);
  EXPECT_THAT(sink_.lines, ElementsAre("begin 1", "0 r10 f0 v3", "1 r20 f0 v3", "2 r30 f10 v3", "end"));
}

TEST_F(CollectorTest, StopsWaitingForAPolicy) {
  config_.actor.wait_for_policy = true;
  policies_.on_look = [this] { stop_ = policies_.looks == 7; };
  Collector collector = Make();
  EXPECT_FALSE(collector.RunEpisode().value());
  EXPECT_EQ(policies_.looks, 7);
}

TEST_F(CollectorTest, ExploresWithThePolicy) {
  PublishPolicy(1, 0.0f);  // standard normal before the squashing
  environment_.decisions = 50;
  Collector collector = Make();
  ASSERT_TRUE(collector.RunEpisode().value());
  for (size_t i = 1; i < environment_.actions.size(); ++i) {
    EXPECT_NE(environment_.actions[i], environment_.actions[i - 1]);
  }
}

class CollectorWithMemory : public CollectorTest {
 protected:
  CollectorWithMemory() {
    auto counting = std::make_unique<CountingPolicy>();
    counting_ = counting.get();
    policy_ = std::move(counting);
  }

  CountingPolicy* counting_ = nullptr;
};

TEST_F(CollectorWithMemory, PolicyForgetsWhereAnEpisodeBeginsAndNowhereElse) {
  PublishPolicy(1);
  environment_.on_step = [&]() -> Status {
    if (environment_.actions.size() == 1) PublishPolicy(2);
    return {};
  };
  Collector collector = Make();
  ASSERT_TRUE(collector.RunEpisode().value());
  ASSERT_TRUE(collector.RunEpisode().value());
  EXPECT_THAT(counting_->calls, ElementsAre("begin", "load", "act 1", "act 2", "load", "act 3", "begin",
                                            "act 1", "act 2", "act 3"));
  EXPECT_EQ(environment_.actions.at(2)[0], 0.03f);
  EXPECT_EQ(environment_.actions.at(3)[0], 0.01f);
}

TEST_F(CollectorWithMemory, PolicyBeginsWithTheEpisodeEvenIfItsParametersComeLater) {
  environment_.on_step = [&]() -> Status {
    if (environment_.actions.size() == 1) PublishPolicy(1);
    return {};
  };
  Collector collector = Make();
  ASSERT_TRUE(collector.RunEpisode().value());
  EXPECT_THAT(counting_->calls, ElementsAre("begin", "load", "act 1"));
}

TEST_F(CollectorWithMemory, PolicyForgetsAnEpisodeThatWasLost) {
  PublishPolicy(1);
  environment_.on_step = [&]() -> Status {
    if (environment_.actions.size() == 2) return Fail(ErrorCode::kInternal, "sumo broke");
    return {};
  };
  Collector collector = Make();
  ASSERT_FALSE(collector.RunEpisode().value());
  environment_.on_step = nullptr;
  environment_.on_reset = []() -> Status { return Fail(ErrorCode::kUnavailable, "no room"); };
  ASSERT_FALSE(collector.RunEpisode().value()) << "an episode that never was";
  environment_.on_reset = nullptr;
  ASSERT_TRUE(collector.RunEpisode().value());
  EXPECT_THAT(counting_->calls,
              ElementsAre("begin", "load", "act 1", "act 2", "act 3", "begin", "act 1", "act 2", "act 3"));
}

TEST_F(CollectorTest, KeepsItsPolicyWhenTheNextIsNotFinite) {
  PublishPolicy(1);
  Collector collector = Make();
  ASSERT_TRUE(collector.RunEpisode().value());
  PublishPolicy(2, std::numeric_limits<float>::quiet_NaN());
  ASSERT_TRUE(collector.RunEpisode().value());
  EXPECT_EQ(collector.progress().policy_version, 1);
  EXPECT_EQ(collector.progress().refused_policies, 1);
  EXPECT_EQ(sink_.lines.at(8), "2 r30 f10 v1");
  PublishPolicy(3);
  ASSERT_TRUE(collector.RunEpisode().value());
  EXPECT_EQ(collector.progress().policy_version, 3);
}

TEST_F(CollectorTest, DrivesTheSameWithTheSameSeeds) {
  Collector first = Make();
  ASSERT_TRUE(first.RunEpisode().value());
  const auto actions = std::exchange(environment_.actions, {});
  const auto seeds = std::exchange(environment_.seeds, {});
  Collector second = Make();
  ASSERT_TRUE(second.RunEpisode().value());
  EXPECT_EQ(environment_.actions, actions);
  EXPECT_EQ(environment_.seeds, seeds);
  environment_.actions.clear();
  Collector restarted = Make(2);
  ASSERT_TRUE(restarted.RunEpisode().value());
  EXPECT_NE(environment_.actions, actions);
  EXPECT_NE(environment_.seeds.back(), seeds.back());
}

TEST_F(CollectorTest, LosesOnlyTheEpisodeInWhichTheSimulatorFails) {
  bool broken = true;
  environment_.on_step = [&]() -> Status {
    if (broken && environment_.actions.size() == 2) return Fail(ErrorCode::kInternal, "sumo broke");
    return {};
  };
  Collector collector = Make();
  EXPECT_FALSE(collector.RunEpisode().value());
  EXPECT_THAT(sink_.lines, ElementsAre("begin 1", "0 r10 f0 v0", "1 r20 f0 v0", "end"));
  broken = false;
  EXPECT_TRUE(collector.RunEpisode().value());
  EXPECT_EQ(collector.progress().simulator_failures, 1);
  EXPECT_EQ(collector.progress().episodes, 1);
  EXPECT_NE(environment_.seeds[0], environment_.seeds[1]);
}

TEST_F(CollectorTest, TriesOtherTrafficWhereTheEgoHasNoRoom) {
  int resets = 0;
  environment_.on_reset = [&]() -> Status {
    if (++resets < 3) return Fail(ErrorCode::kUnavailable, "no room");
    return {};
  };
  Collector collector = Make();
  EXPECT_FALSE(collector.RunEpisode().value());
  EXPECT_FALSE(collector.RunEpisode().value());
  EXPECT_TRUE(collector.RunEpisode().value());
  EXPECT_EQ(collector.progress().simulator_failures, 0);
  EXPECT_THAT(sink_.lines, ElementsAre("begin 3", "0 r10 f0 v0", "1 r20 f0 v0", "2 r30 f10 v0", "end"));
}

TEST_F(CollectorTest, GivesUpOnASimulatorThatAlwaysFails) {
  environment_.on_reset = [] { return Fail(ErrorCode::kInternal, "no libsumo"); };
  Collector collector = Make();
  for (int i = 1; i < Collector::kMaxFailures; ++i) EXPECT_FALSE(collector.RunEpisode().value());
  EXPECT_GT(clock_.Now(), TimePoint{} + std::chrono::seconds(1)) << "it backs off in between";
  const auto last = collector.RunEpisode();
  ASSERT_FALSE(last);
  EXPECT_EQ(last.error().code, ErrorCode::kInternal);
  EXPECT_THAT(last.error().message, ::testing::HasSubstr("no libsumo"));
}

TEST_F(CollectorTest, ASuccessForgivesEarlierFailures) {
  Collector collector = Make();
  for (int i = 0; i < 3 * Collector::kMaxFailures; ++i) {
    environment_.on_reset = [i]() -> Status {
      if (i % 2 == 0) return Fail(ErrorCode::kInternal, "now and then");
      return {};
    };
    EXPECT_TRUE(collector.RunEpisode().has_value());
  }
}

TEST_F(CollectorTest, WaitsOutsideTheSimulatorWhileTheSinkIsBlocked) {
  int polls = 0;
  sink_.is_blocked = [&] { return ++polls < 1000; };
  Collector collector = Make();
  ASSERT_TRUE(collector.RunEpisode().value());
  EXPECT_EQ(environment_.actions.size(), 3);
  EXPECT_NEAR(ledger_.Read()[Activity::kWaitForReplay].seconds, 2.0, 0.01);
  EXPECT_EQ(ledger_.Read()[Activity::kWaitForReplay].count, 1u);
}

TEST_F(CollectorTest, StopsInTheMiddleOfAnEpisodeAndInAWait) {
  environment_.on_step = [&]() -> Status {
    if (environment_.actions.size() == 1) stop_ = true;
    return {};
  };
  Collector collector = Make();
  EXPECT_FALSE(collector.RunEpisode().value());
  EXPECT_THAT(sink_.lines, ElementsAre("begin 1", "0 r10 f0 v0", "1 r20 f0 v0", "end"));
  stop_ = false;
  int polls = 0;
  sink_.is_blocked = [&] {
    if (++polls == 50) stop_ = true;
    return true;
  };
  EXPECT_FALSE(collector.RunEpisode().value());
  EXPECT_EQ(environment_.actions.size(), 2);
}

}  // namespace
}  // namespace dadrl
