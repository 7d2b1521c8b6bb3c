#include "learner/learner_process.h"

#include <memory>
#include <string>

#include "common/dds/cluster_key.h"
#include "common/dds/node.h"
#include "common/io/incarnation.h"
#include "common/util/fault.h"
#include "common/util/log.h"
#include "common/util/shutdown.h"
#include "learner/algorithms/registry.h"
#include "learner/batch_fetcher.h"
#include "learner/checkpoint_store.h"
#include "learner/checkpoint_writer.h"
#include "learner/reporter.h"
#include "learner/resume.h"
#include "learner/trainer.h"
#include "learner/training_log.h"
#include "learner/weight_publisher.h"
#include "proto/telemetry.h"

namespace dadrl {

Status RunLearner(const Config& config, const std::filesystem::path& run_directory, bool resume) {
  // The ports come first: a second learner of the run stops here, before it touches a file.
  DADRL_ASSIGN_OR_RETURN(const std::string key, dds::LoadClusterKey(run_directory, config.cluster));
  DADRL_ASSIGN_OR_RETURN(
      const std::unique_ptr<dds::Node> node,
      dds::Node::Create(config.cluster, config.replay.shards, dds::Role::kLearner, 0, key));
  const uint64_t incarnation = NextIncarnation(run_directory, "learner", WallTimeNs());
  DADRL_ASSIGN_OR_RETURN(const std::unique_ptr<Algorithm> algorithm, MakeAlgorithm(config));
  const std::filesystem::path folder = run_directory / "checkpoints";
  auto store = CheckpointStore::Open(folder, Retention::Of(config));
  if (!store) return tl::unexpected<Error>(std::move(store.error()));
  DADRL_ASSIGN_OR_RETURN(VersionReserve reserve, VersionReserve::Open(folder));
  DADRL_ASSIGN_OR_RETURN(const TrainingProgress progress,
                         BeginTraining(config, *store, reserve.highest(), resume, *algorithm));
  TrainingLog log(run_directory, progress.updates, algorithm->spec().scalars, ProcessFaults());

  SystemClock clock;
  TelemetryPublisher telemetry(config, *node);
  CheckpointWriter checkpoints(std::move(*store), clock);
  DADRL_ASSIGN_OR_RETURN(const auto publisher,
                         WeightPublisher::Create(*node, std::move(reserve), progress.weights_version, clock));
  publisher->Start();
  const auto newest_version = [&publisher] { return publisher->newest_version(); };
  DADRL_ASSIGN_OR_RETURN(const auto fetcher, BatchFetcher::Create(*node, config, algorithm->spec().batch,
                                                                  incarnation, newest_version, clock, {}));
  fetcher->Start();
  Trainer trainer(config, {*algorithm, *fetcher, *publisher, checkpoints, clock}, progress);
  const Reporter reporter(
      config.telemetry,
      {trainer, checkpoints, telemetry, log, [&fetcher] { return fetcher->stats(); }, clock}, incarnation);
  DADRL_ASSIGN_OR_RETURN(const std::string why, trainer.Run(shutdown_requested));
  const FetchStats fetched = fetcher->stats();
  spdlog::info("training ended: {}; it took {} batches of {} inserted frames", why, fetched.batches,
               fetched.frames_inserted);
  spdlog::info(
      "requests: {} sent again, {} moved to another shard; dropped: {} replies corrupt, {} late, {} of "
      "others, "
      "{} updates of priorities",
      fetched.repeated, fetched.given_up, fetched.corrupt, fetched.stale, fetched.foreign,
      fetched.dropped_priorities);
  return {};
}

}  // namespace dadrl
