#include "deploy/lockstep/memory_cluster.h"

#include <utility>

#include "common/step/step_spec_of.h"
#include "common/util/random.h"

namespace dadrl {
namespace {

constexpr uint64_t kReplaySeedIndex = 1;
// Actor and learner start once.
constexpr uint32_t kActor = 0;
constexpr uint64_t kIncarnation = 1;
// Of the cluster's clock: far more than it takes to send anything again.
constexpr Duration kPatience = std::chrono::minutes(1);

// A batch is sampled after the update before it, with its priorities.
Config OneOfEach(Config config) {
  config.replay.shards = 1;
  config.replay.min_samples_per_insert = 0.0;
  config.learner.credits = 1;
  return config;
}

TableOptions InMemoryTable(const Config& config) {
  return {.directory = {},
          .spec = StepSpecOf(config),
          .replay = config.replay,
          .n_step = config.algorithm.n_step,
          .seed = DeriveSeed(config.seed, kReplaySeedIndex),
          .bounds = ExperienceBounds::From(config),
          .verify = nullptr};
}

}  // namespace

MemoryCluster::MemoryCluster(const Config& config) : config_(OneOfEach(config)) {
  clock_.Advance(kPatience);  // its parts take 0 for never
}

Result<std::unique_ptr<MemoryCluster>> MemoryCluster::Create(const Config& config,
                                                             const TrajectoryShape& batch,
                                                             const nn::ParamLayout& policy,
                                                             VersionReserve reserve) {
  std::unique_ptr<MemoryCluster> cluster(new MemoryCluster(config));
  DADRL_RETURN_IF_ERROR(cluster->Open(batch, policy, std::move(reserve)));
  return cluster;
}

Status MemoryCluster::Open(const TrajectoryShape& batch, const nn::ParamLayout& policy,
                           VersionReserve reserve) {
  DADRL_ASSIGN_OR_RETURN(table_, ReplayTable::Open(InMemoryTable(config_), clock_));
  DADRL_ASSIGN_OR_RETURN(ingest_, Ingest::Create(transport_, config_, 0, *table_, clock_, [] {}));
  DADRL_ASSIGN_OR_RETURN(server_, BatchServer::Create(transport_, 0, *table_, clock_, [] {}));
  DADRL_ASSIGN_OR_RETURN(publisher_, WeightPublisher::Create(transport_, std::move(reserve), 0, clock_));
  const auto newest_version = [this] { return publisher_->newest_version(); };
  DADRL_ASSIGN_OR_RETURN(
      fetcher_, BatchFetcher::Create(transport_, config_, batch, kIncarnation, newest_version, clock_, {}));
  DADRL_ASSIGN_OR_RETURN(writer_,
                         ExperienceWriter::Create(transport_, config_, kActor, kIncarnation, clock_));
  DADRL_ASSIGN_OR_RETURN(subscriber_, WeightsSubscriber::Create(transport_, policy.size(), policy.hash()));
  return {};
}

void MemoryCluster::PassExperience() {
  writer_->Step();
  ingest_->Step();
}

Status MemoryCluster::StoreExperience() {
  const TimePoint end = clock_.Now() + kPatience;
  while (!writer_->Flush(Duration::zero())) {
    DADRL_RETURN_IF_ERROR(writer_->status());
    if (clock_.Now() > end) return Fail(ErrorCode::kInternal, "the replay does not store what was driven");
    PassExperience();
  }
  if (writer_->statistics().refused == 0) return {};
  return Fail(ErrorCode::kInternal, "the replay refused a chunk");
}

void MemoryCluster::PassBatch() {
  fetcher_->Step();
  server_->Step(outgoing_);
  fetcher_->Step();
}

}  // namespace dadrl
