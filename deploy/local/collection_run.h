// One `dadrl collect`: actors and replay without a learner, until enough is stored.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/util/clock.h"
#include "common/util/result.h"
#include "deploy/local/episode_log.h"
#include "deploy/local/run_directory.h"
#include "deploy/local/signals.h"
#include "deploy/local/stored_episodes.h"
#include "deploy/local/supervisor.h"

namespace dadrl {

// At least so many, stored; 0: as many as come.
struct CollectionGoal {
  uint64_t episodes = 0;
  uint64_t successes = 0;
  bool ReachedBy(const StoredEpisodes& stored) const;
};

enum class CollectionOutcome {
  kFinished,     // the goal is stored
  kInterrupted,  // on the user's word; --resume goes on
  kFailed,       // a process could not be kept alive, or the user would not wait
};

// Supervises replay and actors: one that is killed is started again, and what counts is what the replay has
// stored. Drains in order: actors, then the replay. Not thread safe; lives on the main thread.
class CollectionRun {
 public:
  // Borrows `signals`; `config` is what was saved to the run directory. `say` gets a line about what
  // happened.
  static Result<std::unique_ptr<CollectionRun>> Create(const RunPaths& paths, const Config& config,
                                                       const CollectionGoal& goal, SignalWatcher& signals,
                                                       std::function<void(const std::string&)> say);

  // Blocks until everything has ended. An error is one of starting.
  Result<CollectionOutcome> Run();
  // After Run.
  const StoredEpisodes& stored() const { return stored_; }

 private:
  enum class Phase { kCollecting, kDrainingActors, kDrainingReplay, kLastCount, kDone };

  CollectionRun(const RunPaths& paths, const Config& config, const CollectionGoal& goal,
                SignalWatcher& signals, std::function<void(const std::string&)> say, EpisodeLog episodes);
  Status Start();
  void WaitForEvents();
  std::vector<pid_t> ChildPids() const;
  void HandleSignals();
  void Advance();
  void Count();
  void Drain(const char* role, Phase next);
  void End(CollectionOutcome outcome, const std::string& why);

  const RunPaths paths_;
  const Config config_;
  const CollectionGoal goal_;
  SignalWatcher& signals_;
  const std::function<void(const std::string&)> say_;
  const SystemClock clock_;
  Supervisor supervisor_;
  EpisodeLog episodes_;
  StoredEpisodeCounter counter_;
  StoredEpisodes stored_;
  std::string trouble_;  // why the last count failed
  TimePoint next_count_{};
  TimePoint next_word_{};
  Phase phase_ = Phase::kCollecting;
  CollectionOutcome outcome_ = CollectionOutcome::kFinished;
};

}  // namespace dadrl
