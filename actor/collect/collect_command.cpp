#include "actor/collect/collect_command.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "actor/collect/actor_episode_log.h"
#include "actor/collect/actor_token.h"
#include "actor/collect/collector.h"
#include "actor/collect/status_reporter.h"
#include "actor/collect/wait_notice.h"
#include "actor/environment.h"
#include "actor/experience/experience_writer.h"
#include "actor/experience/kept_episodes.h"
#include "actor/experience/lease_holder.h"
#include "actor/experience/weights_subscriber.h"
#include "common/dds/cluster_key.h"
#include "common/dds/node.h"
#include "common/io/incarnation.h"
#include "common/liveness/working_thread.h"
#include "common/model/policy_model.h"
#include "common/step/step_spec_of.h"
#include "common/util/exit_code.h"
#include "common/util/fault.h"
#include "common/util/log.h"
#include "common/util/shutdown.h"
#include "proto/telemetry.h"

namespace dadrl {
namespace {

constexpr Duration kDrain = std::chrono::seconds(5);
constexpr Duration kReplayPoll = std::chrono::milliseconds(20);
// A replay that is just starting is not worth a word.
constexpr Duration kQuietWait = std::chrono::seconds(1);

// The parts of one actor, in the order they need each other.
class Actor {
 public:
  static Result<std::unique_ptr<Actor>> Create(const CollectOptions& options);
  Status Run();

 private:
  Actor(const CollectOptions& options, std::unique_ptr<PolicyModel> policy,
        std::unique_ptr<Environment> environment)
      : options_(options), policy_(std::move(policy)), environment_(std::move(environment)) {}

  Status TakeNumber();
  Status Connect();
  std::string WaitingForNumber() const;
  int number() const { return static_cast<int>(identity_.number); }
  void WaitForReplay();
  void Record(const CollectedEpisode& episode);
  Status CheckLayout() const;
  void FillStatus(ProcessStatus& status) const;
  std::string WaitingFor() const;
  void WatchAddress();

  const CollectOptions options_;
  SystemClock clock_;
  TimeLedger ledger_{clock_};
  std::unique_ptr<PolicyModel> policy_;
  std::unique_ptr<Environment> environment_;
  std::unique_ptr<dds::Node> node_;
  std::unique_ptr<TelemetryPublisher> publisher_;
  std::unique_ptr<LeaseHolder> lease_;  // outlives the writer, which shows it
  LeaseHolder::Lease identity_;
  std::unique_ptr<ExperienceWriter> writer_;
  std::unique_ptr<ExperienceSink> kept_;  // before the writer, if not every episode is stored
  std::unique_ptr<WeightsSubscriber> weights_;
  std::unique_ptr<ActorEpisodeLog> log_;
  std::unique_ptr<ScriptedDriver> driver_;  // if not the learner's policy
  std::unique_ptr<Collector> collector_;
  std::unique_ptr<StatusReporter> reporter_;
  Status address_;  // the reporter's thread writes it before it asks for the shutdown
};

Result<std::unique_ptr<Actor>> Actor::Create(const CollectOptions& options) {
  DADRL_ASSIGN_OR_RETURN(auto policy, MakePolicyModel(StepSpecOf(options.config), options.config.model));
  DADRL_ASSIGN_OR_RETURN(auto environment, MakeDrivingEnvironment(options.config));
  std::unique_ptr<Actor> actor(new Actor(options, std::move(policy), std::move(environment)));
  DADRL_RETURN_IF_ERROR(actor->TakeNumber());
  DADRL_RETURN_IF_ERROR(actor->Connect());
  return actor;
}

// Everything that the run knows of this actor has its number in it, so nothing begins before it has one.
Status Actor::TakeNumber() {
  const Config& config = options_.config;
  DADRL_ASSIGN_OR_RETURN(const std::string key, dds::LoadClusterKey(options_.run_directory, config.cluster));
  DADRL_ASSIGN_OR_RETURN(
      node_, dds::Node::Create(config.cluster, config.replay.shards, dds::Role::kActor, options_.index, key));
  const std::string name = fmt::format("actor-{}", options_.index);
  LeaseHolder::Options wanted{.token = KeptToken(options_.run_directory, name),
                              .start = NextIncarnation(options_.run_directory, name, clock_.WallTimeNs()),
                              .number = std::nullopt,
                              .schema = SchemaHash(StepSpecOf(config))};
  if (!options_.any_number) wanted.number = static_cast<uint32_t>(options_.index);
  DADRL_ASSIGN_OR_RETURN(lease_, LeaseHolder::Create(*node_, wanted, clock_));
  WaitNotice notice;
  const TimePoint began = clock_.Now();
  const WorkingThread working("join");
  DADRL_ASSIGN_OR_RETURN(identity_, lease_->Acquire([&] {
    Beat();
    const TimePoint now = clock_.Now();
    if (now - began > kQuietWait) notice.Update(WaitingForNumber(), now);
    return !shutdown_requested;
  }));
  notice.Update({}, clock_.Now());
  return {};
}

Status Actor::Connect() {
  const Config& config = options_.config;
  log_ = std::make_unique<ActorEpisodeLog>(ActorEpisodeLog::Open(
      options_.run_directory / "logs" / fmt::format("episodes-actor-{}.csv", options_.index)));
  publisher_ = std::make_unique<TelemetryPublisher>(config, *node_);
  DADRL_ASSIGN_OR_RETURN(writer_, ExperienceWriter::Create(*node_, config, identity_.number,
                                                           identity_.incarnation, clock_, lease_.get()));
  writer_->Start();
  kept_ = MakeKeptEpisodes(config.actor, *writer_);
  const nn::ParamLayout& layout = policy_->layout();
  DADRL_ASSIGN_OR_RETURN(weights_, WeightsSubscriber::Create(*node_, layout.size(), layout.hash()));
  DADRL_ASSIGN_OR_RETURN(driver_, ScriptedDriver::Make(config));
  collector_ = std::make_unique<Collector>(config,
                                           Collector::Parts{.environment = *environment_,
                                                            .sink = kept_ ? *kept_ : *writer_,
                                                            .policies = *weights_,
                                                            .policy = *policy_,
                                                            .ledger = ledger_,
                                                            .clock = clock_,
                                                            .stop = shutdown_requested,
                                                            .driver = driver_.get()},
                                           identity_.number, identity_.incarnation, log_->last_episode());
  reporter_ = std::make_unique<StatusReporter>(
      *publisher_, config.telemetry,
      StatusEnvelope({dds::Role::kActor, number(), identity_.incarnation}, clock_, ledger_, clock_.Now()),
      clock_,
      StatusReporter::Source{.fill = [this](ProcessStatus& status) { FillStatus(status); },
                             .waiting_for = [this] { return WaitingFor(); },
                             .on_look = [this] { WatchAddress(); }});
  return {};
}

Status Actor::Run() {
  spdlog::info("actor number {} drives {}, cluster at {}:{}", identity_.number, options_.config.scenario,
               options_.config.cluster.host, options_.config.cluster.port);
  const WorkingThread working("collect");
  WaitForReplay();
  ledger_.Enter(Activity::kWork);
  while (!shutdown_requested) {
    DADRL_ASSIGN_OR_RETURN(const auto episode, collector_->RunEpisode());
    if (episode) Record(*episode);
    DADRL_RETURN_IF_ERROR(writer_->status());
    DADRL_RETURN_IF_ERROR(CheckLayout());
  }
  DADRL_RETURN_IF_ERROR(address_);
  const LongWork draining(2 * kDrain);
  const bool drained = writer_->Flush(kDrain);
  const ExperienceWriter::Statistics sent = writer_->statistics();
  if (!drained) {
    spdlog::warn("leaving with {} bytes of experience that the replay has not acknowledged",
                 sent.backlog_bytes);
  }
  spdlog::info("{} chunks, {} acknowledged, {} sent again, {} refused; {} acknowledgements made no sense",
               sent.chunks, sent.acknowledged, sent.resent, sent.refused, sent.invalid_acknowledgements);
  return {};
}

// Experience has nowhere to go before the replay is there; later outages are what the backlog is for.
void Actor::WaitForReplay() {
  const ScopedActivity wait(ledger_, Activity::kWaitForReplay);
  while (!shutdown_requested && !writer_->statistics().replay_present) {
    clock_.SleepFor(kReplayPoll);
    Beat();
  }
}

void Actor::Record(const CollectedEpisode& episode) {
  const EpisodeSummary& summary = episode.summary;
  publisher_->Publish(EpisodeReport{.outcome = static_cast<int>(summary.outcome),
                                    .episode_return = summary.episode_return,
                                    .scenario = summary.scenario});
  ProcessFaults().Report(FaultKind::kEpisodeLog,
                         log_->Append(identity_.incarnation, clock_.WallTimeNs(), episode));
}

// With a policy in use, a stranger's broadcast is only counted; without one, it means that this actor was
// started with another configuration than its learner and would drive at random for ever.
Status Actor::CheckLayout() const {
  if (driver_ || collector_->progress().policy_version > 0 || weights_->refused_layouts() == 0) return {};
  return Fail(ErrorCode::kInvalidArgument,
              "the learner at {} trains another network than this actor's configuration describes: start the "
              "actor with the config.yaml of the run",
              options_.config.cluster.host);
}

void Actor::FillStatus(ProcessStatus& status) const {
  const CollectorProgress progress = collector_->progress();
  const auto set = [&](Metric metric, auto value) { status[metric] = value; };
  set(Metric::kEnvSteps, progress.env_steps);
  set(Metric::kDecisions, progress.decisions);
  set(Metric::kEpisodes, progress.episodes);
  set(Metric::kSuccesses, progress.outcomes[Outcome::kSuccess]);
  set(Metric::kCollisions, progress.outcomes[Outcome::kCollision]);
  set(Metric::kOffRoads, progress.outcomes[Outcome::kOffRoad]);
  set(Metric::kStagnations, progress.outcomes[Outcome::kStagnation]);
  set(Metric::kSimulatorFailures, progress.simulator_failures);
  const ExperienceWriter::Statistics writer = writer_->statistics();
  set(Metric::kBacklogBytes, writer.backlog_bytes);
  set(Metric::kRefusedChunks, writer.refused);
  set(Metric::kPolicyVersion, progress.policy_version);
  if (progress.policy_version > 0) {
    // A wall clock that was set back must not make a policy come from the future.
    const int64_t age_ns = std::max<int64_t>(0, status.sent_ns - weights_->published_ns());
    set(Metric::kPolicyAgeS, age_ns / 1e9);
  }
}

std::string Actor::WaitingForNumber() const {
  const ClusterConfig& cluster = options_.config.cluster;
  const int port = dds::WellKnownPort(cluster, Plane::kControl, 0);
  if (!lease_->connected()) return fmt::format("the replay at {}:{}", cluster.host, port);
  return fmt::format("an actor number from the replay at {}:{}", cluster.host, port);
}

std::string Actor::WaitingFor() const {
  if (writer_->statistics().replay_present) {
    const bool waits =
        !driver_ && options_.config.actor.wait_for_policy && collector_->progress().policy_version == 0;
    return waits ? "the learner's first policy" : std::string();
  }
  const ClusterConfig& cluster = options_.config.cluster;
  const int shard = number() % options_.config.replay.shards;
  return fmt::format("the replay at {}:{}", cluster.host,
                     dds::WellKnownPort(cluster, Plane::kExperience, shard));
}

// A node cannot change its address: the process ends, and is started again with the new one.
void Actor::WatchAddress() {
  if (shutdown_requested) return;
  Status address = node_->CheckAddress();
  if (address) return;
  address_ = std::move(address);
  shutdown_requested = true;
}

}  // namespace

Result<int> RunCollect(const CollectOptions& options) {
  Status done;
  if (auto actor = Actor::Create(options)) {
    done = (*actor)->Run();
  } else if (shutdown_requested) {
    return 0;
  } else {
    done = tl::unexpected<Error>(std::move(actor.error()));
  }
  if (done) return 0;
  // With any other number it could go on; started again, it gets one.
  if (done.error().code != ErrorCode::kExhausted || options.any_number) {
    return tl::unexpected<Error>(std::move(done.error()));
  }
  spdlog::error("{}", done.error().message);
  return kExitTurnedAway;
}

}  // namespace dadrl
