// The cluster between driving and training, within one thread: its parts on memory ports, which take turns
// when they are told to.
#pragma once

#include <memory>

#include "actor/experience/experience_writer.h"
#include "actor/experience/weights_subscriber.h"
#include "common/config/config.h"
#include "common/nn/param_layout.h"
#include "common/port/memory_transport.h"
#include "common/util/clock.h"
#include "common/util/result.h"
#include "learner/batch_fetcher.h"
#include "learner/version_reserve.h"
#include "learner/weight_publisher.h"
#include "replay/service/batch_server.h"
#include "replay/service/ingest.h"
#include "replay/table.h"

namespace dadrl {

// One actor, one shard in memory, one learner. What happens depends on the calls alone: no thread, and no
// clock but one of its own, which passes while its parts wait.
class MemoryCluster {
 public:
  // Of the actor's and learner's settings those that mean several at once do not count: replay.shards,
  // learner.credits; nor does replay.min_samples_per_insert, since driving never runs ahead. `policy`: of the
  // parameters that are published. kInvalidArgument: BatchFetcher::Create.
  static Result<std::unique_ptr<MemoryCluster>> Create(const Config& config, const TrajectoryShape& batch,
                                                       const nn::ParamLayout& policy, VersionReserve reserve);

  ExperienceSink& experience() { return *writer_; }
  PolicySource& policies() { return *subscriber_; }
  BatchSource& batches() { return *fetcher_; }
  PolicyPublisher& publisher() { return *publisher_; }

  // Carries chunks to the table as far as there are any: a turn.
  void PassExperience();
  // Until all that was driven is stored. An error says that it cannot be.
  Status StoreExperience();
  // Carries priorities to the table, and then a batch from it, unless the replay withholds it.
  void PassBatch();
  // Carries what was published last to the actor.
  void PassPolicy() { publisher_->Step(); }

 private:
  explicit MemoryCluster(const Config& config);
  Status Open(const TrajectoryShape& batch, const nn::ParamLayout& policy, VersionReserve reserve);

  const Config config_;
  ManualClock clock_;
  const MemoryTransport transport_{clock_};
  std::unique_ptr<ReplayTable> table_;
  std::unique_ptr<Ingest> ingest_;
  std::unique_ptr<BatchServer> server_;
  BatchServer::Outgoing outgoing_;
  std::unique_ptr<WeightPublisher> publisher_;
  std::unique_ptr<BatchFetcher> fetcher_;
  std::unique_ptr<ExperienceWriter> writer_;
  std::unique_ptr<WeightsSubscriber> subscriber_;
};

}  // namespace dadrl
