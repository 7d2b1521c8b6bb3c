#include "deploy/lockstep/lockstep.h"

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "actor/collect/collector.h"
#include "actor/collect/scripted_driver.h"
#include "actor/environment.h"
#include "actor/experience/kept_episodes.h"
#include "common/io/checksum.h"
#include "common/model/policy_model.h"
#include "common/step/step_spec_of.h"
#include "common/util/log.h"
#include "deploy/lockstep/memory_cluster.h"
#include "learner/algorithms/registry.h"
#include "learner/checkpoint_store.h"
#include "learner/checkpoint_writer.h"
#include "learner/resume.h"
#include "learner/trainer.h"

namespace dadrl {
namespace {

// The processor's and the system's time are nothing to a training that repeats.
Duration NoTime() { return {}; }

Status CheckEnds(const Config& config) {
  if (config.learner.max_updates == 0 && config.minutes == 0.0) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "a deterministic training needs an end: set learner.max_updates or minutes (of {} updates each)",
        60.0 / kLockstepUpdateSeconds);
  }
  if (config.learner.max_cpu_seconds > 0.0) {
    return Fail(ErrorCode::kInvalidArgument,
                "learner.max_cpu_seconds: {} would end a deterministic training at another update each time; "
                "set it to 0, and learner.max_updates instead",
                config.learner.max_cpu_seconds);
  }
  if (config.replay.samples_per_insert == 0.0 && config.replay.max_times_sampled == 0) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "replay.samples_per_insert: 0 leaves open how many updates follow an episode; a deterministic "
        "training needs it, or replay.max_times_sampled, above 0");
  }
  return {};
}

// Who acts in what.
struct Driving {
  std::unique_ptr<Environment> environment;
  std::unique_ptr<PolicyModel> policy;
  std::unique_ptr<ScriptedDriver> driver;  // in place of the policy, or null

  static Result<Driving> Make(const Config& config) {
    Driving driving;
    DADRL_ASSIGN_OR_RETURN(driving.environment, MakeDrivingEnvironment(config));
    DADRL_ASSIGN_OR_RETURN(driving.policy, MakePolicyModel(StepSpecOf(config), config.model));
    DADRL_ASSIGN_OR_RETURN(driving.driver, ScriptedDriver::Make(config));
    return driving;
  }
};

// Who waits for room lets the experience move on; no time passes.
class Turns final : public Clock {
 public:
  Turns(const Clock& clock, MemoryCluster& cluster) : clock_(clock), cluster_(cluster) {}
  TimePoint Now() const override { return clock_.Now(); }
  int64_t WallTimeNs() const override { return clock_.WallTimeNs(); }
  void SleepFor(Duration) override { cluster_.PassExperience(); }

 private:
  const Clock& clock_;
  MemoryCluster& cluster_;
};

// Driving, storing and training in turns, on one thread and a clock that only updates move.
class Lockstep {
 public:
  Lockstep(const Config& config, Driving driving, std::unique_ptr<Algorithm> algorithm,
           std::unique_ptr<MemoryCluster> cluster, CheckpointStore store, const TrainingProgress& progress,
           const std::atomic<bool>& stop)
      : config_(config),
        stop_(stop),
        driving_(std::move(driving)),
        algorithm_(std::move(algorithm)),
        cluster_(std::move(cluster)),
        kept_(MakeKeptEpisodes(config.actor, cluster_->experience())),
        turns_(clock_, *cluster_),
        checkpoints_(std::move(store), clock_),
        trainer_(
            config,
            {*algorithm_, cluster_->batches(), cluster_->publisher(), checkpoints_, clock_, NoTime, NoTime},
            progress),
        collector_(config,
                   {.environment = *driving_.environment,
                    .sink = kept_ ? *kept_ : cluster_->experience(),
                    .policies = cluster_->policies(),
                    .policy = *driving_.policy,
                    .ledger = ledger_,
                    .clock = turns_,
                    .stop = stop,
                    .driver = driving_.driver.get()},
                   0, 0) {}

  Result<LockstepResult> Run() {
    // Nothing to train on yet, but a policy that is published untrained.
    DADRL_RETURN_IF_ERROR(TrainWhileAllowed());
    while (!stop_ && !EndReached()) {
      cluster_->PassPolicy();
      DADRL_RETURN_IF_ERROR(collector_.RunEpisode().map([](const auto&) {}));
      DADRL_RETURN_IF_ERROR(cluster_->StoreExperience());
      DADRL_RETURN_IF_ERROR(TrainWhileAllowed());
    }
    DADRL_RETURN_IF_ERROR(trainer_.SaveNow());
    const CollectorProgress driven = collector_.progress();
    return LockstepResult{.updates = updates_,
                          .episodes = driven.episodes,
                          .decisions = driven.decisions,
                          .policy_hash = Xxh3(std::as_bytes(algorithm_->published_policy().parameters))};
  }

 private:
  bool EndReached() const {
    const auto max_updates = static_cast<uint64_t>(config_.learner.max_updates);
    return (max_updates > 0 && updates_ >= max_updates) ||
           (config_.minutes > 0.0 && ToSeconds(clock_.Now().time_since_epoch()) >= 60.0 * config_.minutes);
  }

  // Trains until the replay holds samples back.
  Status TrainWhileAllowed() {
    while (!stop_ && !EndReached()) {
      cluster_->PassBatch();
      DADRL_ASSIGN_OR_RETURN(const Trainer::Step step, trainer_.RunStep(Duration::zero()));
      if (step == Trainer::Step::kNoBatch) return {};
      ++updates_;
      clock_.Advance(FromSeconds(kLockstepUpdateSeconds));
    }
    return {};
  }

  const Config config_;
  const std::atomic<bool>& stop_;
  ManualClock clock_;
  TimeLedger ledger_{clock_};
  Driving driving_;
  std::unique_ptr<Algorithm> algorithm_;
  std::unique_ptr<MemoryCluster> cluster_;
  const std::unique_ptr<ExperienceSink> kept_;  // before the cluster, if not every episode is stored
  Turns turns_;
  CheckpointWriter checkpoints_;
  Trainer trainer_;
  Collector collector_;
  uint64_t updates_ = 0;
};

}  // namespace

Result<LockstepResult> TrainInLockstep(const Config& config, const std::filesystem::path& run_directory,
                                       const std::atomic<bool>& stop) {
  DADRL_RETURN_IF_ERROR(CheckEnds(config));
  auto store = CheckpointStore::Open(run_directory / "checkpoints", Retention::Of(config));
  if (!store) return tl::unexpected<Error>(std::move(store.error()));
  DADRL_ASSIGN_OR_RETURN(auto algorithm, MakeAlgorithm(config));
  DADRL_ASSIGN_OR_RETURN(const TrainingProgress progress,
                         BeginTraining(config, *store, 0, false, *algorithm));
  DADRL_ASSIGN_OR_RETURN(Driving driving, Driving::Make(config));
  DADRL_ASSIGN_OR_RETURN(VersionReserve reserve, VersionReserve::Open(run_directory / "checkpoints"));
  DADRL_ASSIGN_OR_RETURN(auto cluster, MemoryCluster::Create(config, algorithm->spec().batch,
                                                             driving.policy->layout(), std::move(reserve)));
  Lockstep lockstep(config, std::move(driving), std::move(algorithm), std::move(cluster), std::move(*store),
                    progress, stop);
  return lockstep.Run();
}

}  // namespace dadrl
