#include "actor/collect/collector.h"

#include <algorithm>

#include "actor/collect/episode_seeds.h"
#include "common/liveness/working_thread.h"
#include "common/util/log.h"
#include "proto/experience.h"

namespace dadrl {
namespace {

constexpr double kSimulationStepS = 0.1;
constexpr Duration kRoomPoll = std::chrono::milliseconds(2);
constexpr Duration kPolicyPoll = std::chrono::milliseconds(10);
constexpr int kPolicyPolls = 100;  // until the caller may look at what is wrong
constexpr Duration kFirstBackOff = std::chrono::milliseconds(100);
constexpr Duration kLongestBackOff = std::chrono::seconds(4);

}  // namespace

Collector::Collector(const Config& config, const Parts& parts, uint32_t actor, uint64_t incarnation,
                     uint64_t last_episode)
    : config_(config),
      parts_(parts),
      actor_(actor),
      incarnation_(incarnation),
      random_(ActionSeed(config.seed, actor, incarnation)),
      random_actions_(kSimulationStepS * config.task.decision_interval),
      before_(DrivingShape::From(config.observation)),
      decision_columns_(DrivingStepSpec(config).decision),
      decision_(DrivingStepSpec(config).decision_floats()),
      episode_(last_episode) {}

Result<std::optional<CollectedEpisode>> Collector::RunEpisode() {
  if (!WaitForPolicy()) return std::nullopt;
  seed_ = TrainingSeed(config_.seed, actor_, incarnation_, ++episode_);
  DADRL_ASSIGN_OR_RETURN(const bool ready, Reset());
  if (!ready) return std::nullopt;
  steps_before_ = progress().env_steps;
  random_actions_.Restart();
  parts_.policy.BeginEpisode();
  if (parts_.driver != nullptr) parts_.driver->BeginEpisode(seed_);
  parts_.sink.BeginEpisode(episode_);
  while (WaitForRoom()) {
    TakePolicy();
    const Result<bool> ended = Decide();
    if (!ended) return Lose(ended.error());
    if (!*ended) continue;
    parts_.sink.EndEpisode();
    failures_ = 0;
    const EpisodeSummary& summary = parts_.environment.summary();
    MutexLock lock(mutex_);
    ++progress_.episodes;
    ++progress_.outcomes[summary.outcome];
    progress_.env_steps = steps_before_ + static_cast<uint64_t>(summary.steps);
    return CollectedEpisode{episode_, summary, version_};
  }
  parts_.sink.EndEpisode();
  return std::nullopt;
}

Result<bool> Collector::Reset() {
  const ScopedActivity wait(parts_.ledger, Activity::kWaitForSimulator);
  const Status status = parts_.environment.Reset(seed_);
  if (status) {
    spawn_failures_ = 0;
    return true;
  }
  if (status.error().code == ErrorCode::kInvalidArgument) return tl::unexpected<Error>(status.error());
  if (status.error().code != ErrorCode::kUnavailable) {
    DADRL_RETURN_IF_ERROR(Lose(status.error()));
    return false;
  }
  if (++spawn_failures_ >= kMaxSpawnFailures) {
    return Fail(ErrorCode::kInternal, "no room for the ego in {} traffics in a row; the last: {}",
                spawn_failures_, status.error().message);
  }
  return false;
}

Result<bool> Collector::Decide() {
  before_ = parts_.environment.observation();
  const Action action = Act();
  DADRL_ASSIGN_OR_RETURN(const StepResult step, parts_.environment.Step(action));
  parts_.sink.AddTransition(before_, decision_, step.reward, FlagsOf(step), version_);
  if (step.truncated) parts_.sink.AddFinal(parts_.environment.observation());
  MutexLock lock(mutex_);
  ++progress_.decisions;
  progress_.env_steps += static_cast<uint64_t>(config_.task.decision_interval);
  return step.ended();
}

uint8_t Collector::FlagsOf(const StepResult& step) const {
  if (step.truncated) return kTruncated;
  if (!step.terminated) return 0;
  const bool success = parts_.environment.summary().outcome == Outcome::kSuccess;
  return static_cast<uint8_t>(kTerminated | (success ? kSuccess : 0));
}

Action Collector::Act() {
  std::ranges::fill(decision_, 0.0f);
  Action action;
  if (parts_.driver != nullptr) {
    action = parts_.driver->Act(parts_.environment);
  } else if (version_ == 0) {
    action = random_actions_.Next(random_);
  } else {
    action = parts_.policy.Act(before_, &random_);
    RecordDecision();
  }
  std::ranges::copy(action, decision_.begin());
  return action;
}

void Collector::RecordDecision() {
  const PolicyModel::Details& details = parts_.policy.last();
  auto at = decision_.begin();
  for (const ColumnSpec& column : decision_columns_) {
    const std::span<const float> values = details.Find(column.name);
    if (values.size() == column.elements()) std::ranges::copy(values, at);
    at += static_cast<ptrdiff_t>(column.elements());
  }
}

Result<std::optional<CollectedEpisode>> Collector::Lose(const Error& error) {
  parts_.sink.EndEpisode();
  {
    MutexLock lock(mutex_);
    ++progress_.simulator_failures;
  }
  if (++failures_ >= kMaxFailures) {
    return Fail(ErrorCode::kInternal, "{} episodes in a row were lost to the simulator; the last: {}",
                failures_, error.message);
  }
  const LongWork backing_off(kLongestBackOff);
  spdlog::warn("episode {} (traffic seed {}) is lost: {}", episode_, seed_, error.message);
  parts_.clock.SleepFor(std::min(kLongestBackOff, kFirstBackOff * (1 << std::min(failures_ - 1, 5))));
  return std::nullopt;
}

bool Collector::WaitForPolicy() {
  if (!config_.actor.wait_for_policy || parts_.driver != nullptr) return true;
  TakePolicy();
  if (version_ != 0) return true;
  const ScopedActivity wait(parts_.ledger, Activity::kWaitForWeights);
  for (int poll = 0; poll < kPolicyPolls && version_ == 0 && !parts_.stop; ++poll) {
    parts_.clock.SleepFor(kPolicyPoll);
    Beat();
    TakePolicy();
  }
  return version_ != 0;
}

bool Collector::WaitForRoom() {
  if (parts_.stop) return false;
  if (!parts_.sink.blocked()) return true;
  const ScopedActivity wait(parts_.ledger, Activity::kWaitForReplay);
  while (parts_.sink.blocked()) {
    if (parts_.stop) return false;
    parts_.clock.SleepFor(kRoomPoll);
    Beat();
  }
  return true;
}

void Collector::TakePolicy() {
  if (parts_.driver != nullptr) return;
  const uint32_t newer = parts_.policies.TakeNewer(newest_version_, parameters_);
  if (newer == 0) return;
  newest_version_ = newer;
  const Status loaded = parts_.policy.Load(parameters_);
  MutexLock lock(mutex_);
  if (!loaded) {
    ++progress_.refused_policies;
    spdlog::error("policy {} is refused, policy {} stays: {}", newer, version_, loaded.error().message);
    return;
  }
  version_ = newer;
  progress_.policy_version = newer;
}

CollectorProgress Collector::progress() const {
  MutexLock lock(mutex_);
  return progress_;
}

}  // namespace dadrl
