// The collecting loop: drive an episode with the newest policy, hand its frames to the sink.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "actor/collect/random_actions.h"
#include "actor/collect/scripted_driver.h"
#include "actor/environment.h"
#include "actor/experience/experience_sink.h"
#include "common/config/config.h"
#include "common/model/policy_model.h"
#include "common/util/clock.h"
#include "common/util/enum_array.h"
#include "common/util/mutex.h"
#include "common/util/random.h"
#include "common/util/time_ledger.h"

namespace dadrl {

// Cumulative since the collector began.
struct CollectorProgress {
  uint64_t env_steps = 0;  // simulation steps
  uint64_t decisions = 0;
  uint64_t episodes = 0;
  EnumArray<Outcome, uint64_t, kOutcomes> outcomes{};
  uint64_t simulator_failures = 0;  // episodes lost to the simulator
  uint64_t refused_policies = 0;    // that arrived but could not be loaded
  uint32_t policy_version = 0;      // in use, now; 0: acting at random
};

// A finished episode.
struct CollectedEpisode {
  uint64_t episode = 0;
  EpisodeSummary summary{};
  uint32_t policy_version = 0;  // in use when it ended
};

// Acts at random until the first policy arrives, or waits for it (actor.wait_for_policy), then samples from
// the policy; or acts as a scripted driver does. RunEpisode belongs to one thread, which beats while it waits
// (the environment beats while it drives); progress may be read by any.
class Collector {
 public:
  // Borrowed for the collector's life.
  struct Parts {
    Environment& environment;
    ExperienceSink& sink;
    PolicySource& policies;
    PolicyModel& policy;
    TimeLedger& ledger;
    Clock& clock;
    const std::atomic<bool>& stop;
    ScriptedDriver* driver = nullptr;  // drives in place of the policies, if there is one
  };

  // Numbers episodes from `last_episode` + 1 on: what the actor finished before it was restarted has the
  // numbers up to that.
  Collector(const Config& config, const Parts& parts, uint32_t actor, uint64_t incarnation,
            uint64_t last_episode = 0);

  // Drives one episode. Nothing when it was cut by `stop` or lost to the simulator (counted; the frames so
  // far stay valid experience), or did not begin because no policy has come for a second. Waits, outside the
  // simulator, while the sink is blocked. An error when the simulator fails again and again: going on is
  // pointless.
  Result<std::optional<CollectedEpisode>> RunEpisode();

  CollectorProgress progress() const;

  // Failures in a row after which RunEpisode gives up.
  static constexpr int kMaxFailures = 10;
  static constexpr int kMaxSpawnFailures = 100;

 private:
  // The simulator is ready, or this episode is lost (false), or there is no hope.
  Result<bool> Reset();
  // How the frame before it ends, as it is stored.
  uint8_t FlagsOf(const StepResult& step) const;
  // For the observation in before_; leaves the decision columns in decision_.
  Action Act();
  // Fills the decision columns behind the action from what the policy says of its last Act under their names.
  void RecordDecision();
  // One decision; true when the episode ended.
  Result<bool> Decide();
  Result<std::optional<CollectedEpisode>> Lose(const Error& error);
  // False when stopped, or none has come for a while.
  bool WaitForPolicy();
  // False when stopped.
  bool WaitForRoom();
  void TakePolicy();

  const Config config_;
  const Parts parts_;
  const uint32_t actor_;
  const uint64_t incarnation_;
  Random random_;
  RandomActions random_actions_;
  Observation before_;  // the observation that the action answers
  const std::vector<ColumnSpec> decision_columns_;
  std::vector<float> decision_;    // their values; zero where who drives says nothing of them
  std::vector<float> parameters_;  // scratch of TakePolicy
  uint64_t episode_;
  uint64_t seed_ = 0;
  uint32_t newest_version_ = 0;  // arrived, loaded or refused
  uint32_t version_ = 0;         // in use
  uint64_t steps_before_ = 0;    // env_steps when the episode began
  int failures_ = 0;             // in a row
  int spawn_failures_ = 0;       // in a row

  mutable Mutex mutex_;
  CollectorProgress progress_ DADRL_GUARDED_BY(mutex_);
};

}  // namespace dadrl
