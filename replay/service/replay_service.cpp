#include "replay/service/replay_service.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <thread>
#include <utility>

#include "common/config/config_yaml.h"
#include "common/dds/cluster_key.h"
#include "common/step/step_spec_of.h"
#include "common/util/fault.h"
#include "common/util/log.h"
#include "common/util/random.h"
#include "proto/borrowed_sequence.h"
#include "replay/service/chunk_verifier.h"

namespace dadrl {
namespace {

constexpr Duration kTick = std::chrono::milliseconds(20);

TableOptions OptionsOf(const ReplayService::Options& options) {
  const StepSpec spec = StepSpecOf(options.config);
  TableOptions table{.directory = options.run_directory / "replay" / fmt::format("shard-{}", options.shard),
                     .spec = spec,
                     .replay = options.config.replay,
                     .n_step = options.config.algorithm.n_step,
                     .seed = DeriveSeed(options.config.seed, 1000 + options.shard),
                     .bounds = ExperienceBounds::From(options.config),
                     .verify = nullptr};
  if (options.config.replay.verify_frames != VerifyFrames::kNone) {
    // Shared only because a std::function must be copyable.
    const auto verifier = std::make_shared<ChunkVerifier>(
        spec, options.config.replay.verify_frames == VerifyFrames::kAll, table.seed);
    table.verify = [verifier](const ChunkView& chunk) { return verifier->Check(chunk); };
  }
  return table;
}

}  // namespace

Result<std::unique_ptr<ReplayService>> ReplayService::Create(const Options& options, Clock& clock) {
  std::unique_ptr<ReplayService> service(new ReplayService(options, clock));
  service->started_ = clock.Now();
  DADRL_ASSIGN_OR_RETURN(service->table_, ReplayTable::Open(OptionsOf(options), clock));
  // A disk that is full or read-only is found now, not when the first actor waits for its acknowledgement.
  // What is stored can be served all the same.
  ProcessFaults().Report(FaultKind::kState, service->table_->SaveState());
  DADRL_RETURN_IF_ERROR(service->Join());
  return service;
}

Status ReplayService::Join() {
  const Config& config = options_.config;
  DADRL_ASSIGN_OR_RETURN(const std::string key, dds::LoadClusterKey(options_.run_directory, config.cluster));
  DADRL_ASSIGN_OR_RETURN(node_, dds::Node::Create(config.cluster, config.replay.shards, dds::Role::kReplay,
                                                  static_cast<int>(options_.shard), key));
  if (options_.shard == 0) DADRL_RETURN_IF_ERROR(AnnounceRun());
  telemetry_ = std::make_unique<TelemetryPublisher>(config, *node_);
  DADRL_ASSIGN_OR_RETURN(
      server_, BatchServer::Create(*node_, options_.shard, *table_, clock_, [this] { ingest_->Wake(); }));
  DADRL_ASSIGN_OR_RETURN(
      ingest_, Ingest::Create(*node_, config, options_.shard, *table_, clock_, [this] { server_->Wake(); }));
  envelope_.emplace(
      StatusEnvelope::Sender{dds::Role::kReplay, static_cast<int>(options_.shard), options_.incarnation},
      clock_, server_->ledger(), started_);
  maintenance_ =
      std::make_unique<Maintenance>(config.replay, options_.shard, options_.run_directory, *table_, clock_);
  DADRL_ASSIGN_OR_RETURN(commands_,
                         CommandServer::Create(*node_, options_.shard, *table_, *maintenance_, [this] {
                           ingest_->Wake();
                           server_->Wake();
                         }));
  return {};
}

Status ReplayService::AnnounceRun() {
  const Config& config = options_.config;
  const std::string yaml = ToYaml(config, false);
  dadrl_idl_RunConfig message{};
  message.port = config.cluster.port;
  Borrow(yaml, message.yaml);
  DADRL_ASSIGN_OR_RETURN(run_config_, Writer<dadrl_idl_RunConfig>::Create(*node_, kRunConfigTopic));
  DADRL_RETURN_IF_ERROR(run_config_->Write(message));
  DADRL_ASSIGN_OR_RETURN(run_state_, Writer<dadrl_idl_RunState>::Create(*node_, kRunStateTopic));
  PublishState(false);
  DADRL_RETURN_IF_ERROR(OpenLeases());
  if (!config.telemetry.enabled) return {};
  DADRL_ASSIGN_OR_RETURN(relay_, TelemetryRelay::Create(*node_, config.cluster));
  return {};
}

Status ReplayService::OpenLeases() {
  uint64_t least = 0;
  for (const SequenceTable::Stream& stream : table_->Streams()) {
    least = std::max(least, stream.incarnation + 1);
  }
  DADRL_ASSIGN_OR_RETURN(leases_,
                         LeaseServer::Create(*node_, options_.config, table_->schema(), least, clock_));
  return {};
}

// Whoever has joined waits for a replay that was killed, and not for one that ends with its run.
void ReplayService::PublishState(bool ending) {
  if (!run_state_) return;
  const dadrl_idl_RunState state{
      .port = options_.config.cluster.port, .incarnation = options_.incarnation, .ending = ending};
  if (const Status said = run_state_->Write(state); !said) {
    spdlog::warn("state of the run: {}", said.error().message);
  }
}

Status ReplayService::Run(const std::atomic<bool>& stop) {
  std::atomic<bool> stopping{false};
  std::thread ingest([&] { ingest_->Run(stopping); });
  std::thread server([&] { server_->Run(stopping); });
  std::thread maintenance([&] { maintenance_->Run(stopping); });
  const ReplayTable::Stats stats = table_->stats();
  spdlog::info("shard {} serves {} frames ({} MB on disk)", options_.shard, stats.frames_held,
               stats.disk_bytes / 1000000);
  const Duration status_interval = FromSeconds(options_.config.telemetry.interval_s);
  TimePoint next_status = clock_.Now();
  while (!stop.load()) {
    const TimePoint now = clock_.Now();
    if (now >= next_status) {
      PublishStatus();
      next_status = now + status_interval;
    }
    if (relay_) relay_->Pass();
    if (leases_) leases_->Serve();
    commands_->Serve();
    clock_.SleepFor(kTick);
  }
  PublishState(true);
  stopping = true;
  ingest.join();
  server.join();
  maintenance.join();
  PublishStatus();
  DADRL_RETURN_IF_ERROR(table_->Sync());
  DADRL_RETURN_IF_ERROR(table_->SaveState());
  spdlog::info("shard {} stopped with {} frames, after {} batches", options_.shard,
               table_->stats().frames_held, server_->statistics().batches);
  return {};
}

void ReplayService::PublishStatus() {
  const ReplayTable::Stats table = table_->stats();
  // Its activities show the server's thread: which side is slower.
  ProcessStatus status = envelope_->Begin();
  status[Metric::kInsertedFrames] = table.inserted_frames;
  status[Metric::kInsertedBytes] = table.inserted_bytes;
  status[Metric::kSampledTransitions] = table.sampled;
  status[Metric::kSampledBytes] = server_->statistics().bytes;
  std::copy(table.rejected_chunks.begin(), table.rejected_chunks.end(), &status[Metric::kRejectedGarbage]);
  status[Metric::kDuplicateChunks] = table.duplicate_chunks;
  status[Metric::kLostChunks] = table.lost_chunks;
  status[Metric::kRefusedRequests] = server_->statistics().refused_requests;
  status[Metric::kRefusedPriorities] = table.refused_priorities;
  status[Metric::kFramesHeld] = table.frames_held;
  status[Metric::kMemoryBytes] = ResidentBytes();
  status[Metric::kDiskBytes] = table.disk_bytes;
  status[Metric::kSnapshotBytes] = maintenance_->snapshot_bytes();
  // From the ingest thread come only the waits it alone has.
  const ActivityTotals ingest = ingest_->ledger().Read();
  for (const Activity activity : {Activity::kWaitForSamples, Activity::kWaitForDisk}) {
    status.activities[activity] = ingest[activity];
  }
  // Within its work: inserts that had to begin a segment.
  TimeSpent& for_disk = status.activities[Activity::kWaitForDisk];
  for_disk.count += table.for_disk.count;
  for_disk.seconds += table.for_disk.seconds;
  telemetry_->Publish(status);
}

uint64_t ResidentBytes() {
  std::ifstream statm("/proc/self/statm");
  uint64_t total = 0;
  uint64_t resident = 0;
  if (!(statm >> total >> resident)) return 0;
  return resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace dadrl
