// Telemetry of a cluster: over LCM on the replay's host, through replay shard 0 from elsewhere. Small, lossy,
// state not events. Every counter is cumulative, so a lost packet loses nothing but freshness; the monitor
// takes differences.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/config.h"
#include "common/dds/node.h"
#include "common/util/enum_array.h"
#include "common/util/fault.h"
#include "common/util/result.h"
#include "common/util/time_ledger.h"
#include "proto/named_scalar.h"

namespace dadrl {

// What a process may report; a process fills those that it knows, the rest stay 0.
enum class Metric : int {
  // actor, cumulative
  kEnvSteps = 0,  // simulation steps of 0.1 s
  kDecisions,     // frames produced
  kEpisodes,
  kSuccesses,
  kCollisions,
  kOffRoads,
  kStagnations,
  kSimulatorFailures,  // episodes lost to the simulator
  kBacklogBytes,       // unacknowledged experience, now
  kPolicyVersion,      // in use, now
  kPolicyAgeS,         // since that policy was published, now
  kRefusedChunks,      // that the replay will never take; dropped
  // replay, cumulative unless "now"
  kInsertedFrames,
  kInsertedBytes,
  kSampledTransitions,
  kSampledBytes,
  kRejectedGarbage,  // chunks that were not taken, by ChunkFault and in its order
  kRejectedVersion,
  kRejectedLength,
  kRejectedChecksum,
  kRejectedContents,
  kRejectedSchema,
  kRejectedStale,
  kDuplicateChunks,    // stored before; dropped
  kLostChunks,         // skipped: their actors no longer have them
  kRefusedRequests,    // for batches that could never be served
  kRefusedPriorities,  // that no error has; their items keep theirs
  kFramesHeld,         // now
  kMemoryBytes,        // now
  kDiskBytes,          // now
  kSnapshotBytes,      // now, held by snapshots alone
  // learner
  kUpdates,                // cumulative
  kWeightsVersion,         // now
  kBatchBytes,             // cumulative, received
  kCorruptBatches,         // cumulative, dropped
  kStalenessVersionsMean,  // of the last batches: newest version minus the acting one
  kStalenessVersionsMax,
  kStalenessSecondsMean,  // the same in seconds
  kStalenessSecondsMax,
  kCheckpointAgeS,
  kLearnerCpuS,  // cumulative, processor time over all sessions of the run
  kCount,
};

// Stable snake_case name ("env_steps").
std::string_view MetricName(Metric metric);

// The largest number of an actor.
constexpr int kMaxActorNumber = 1'000'000;

struct ProcessStatus {
  // What one message has room for; more than so many faults at once, and longer texts, are cut.
  static constexpr size_t kMaxFaults = 4;
  static constexpr size_t kMaxFaultText = 191;

  dds::Role role = dds::Role::kActor;
  int index = 0;
  int pid = 0;
  uint64_t incarnation = 0;
  int64_t sent_ns = 0;  // wall time
  double uptime_s = 0.0;
  EnumArray<Metric, double> metrics{};
  ActivityTotals activities;  // cumulative, of the process's main loop
  std::vector<Fault> faults;  // that last now; printable ASCII, anything else is sent as '?'
  // Means over the last interval. Sent are the first kMaxScalars that a reader would take.
  std::vector<NamedScalar> scalars;

  double& operator[](Metric metric) { return metrics[metric]; }
  double operator[](Metric metric) const { return metrics[metric]; }
};

// One finished episode, for the rates of those just driven; all of it is in the actor's own table
// (evaluation/episode_row.h). `outcome` is the integer of an Outcome.
struct EpisodeReport {
  static constexpr size_t kMaxScenarioName = 31;

  int outcome = 0;
  double episode_return = 0.0;
  std::string scenario;  // cut to kMaxScenarioName bytes of UTF-8
};

// Host-local (ttl 0) multicast on a port of the cluster's own block, so that clusters on one host do not mix.
std::string TelemetryUrl(const ClusterConfig& cluster);

// The LCM channel of either packet.
const char* TelemetryChannel(bool is_episode);

// Thread safe; never blocks. Where it cannot publish it says so once.
class TelemetryPublisher {
 public:
  // LCM alone. `url`: TelemetryUrl; empty: off.
  explicit TelemetryPublisher(const std::string& url);
  // As the cluster's processes do it: LCM on the replay's host, and where that is another one, or this one
  // does not hear its own multicast, to the relay of replay shard 0. Off when the configuration says so.
  // Borrows `node`.
  TelemetryPublisher(const Config& config, const dds::Node& node);
  ~TelemetryPublisher();
  void Publish(const ProcessStatus& status);
  void Publish(const EpisodeReport& report);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Packets that were not taken, by kind ("fragment"); only what happened.
using TelemetryRefusals = std::map<std::string, uint64_t>;

// Not thread safe. Of LCM only what was sent on this host is heard. Packets of the wrong length or type are
// counted and dropped before they are decoded.
class TelemetrySubscriber {
 public:
  // LCM alone. kUnavailable when the host does not hear its own multicast.
  static Result<std::unique_ptr<TelemetrySubscriber>> Create(const std::string& url);
  // What the relay of replay shard 0 passes on: nothing of processes that LCM reaches. Joins DDS.
  // `key`: the run's, or "".
  static Result<std::unique_ptr<TelemetrySubscriber>> CreateRelayed(const Config& config,
                                                                    const std::string& key = {});
  // LCM, or the relay where the host does not hear its own multicast.
  static Result<std::unique_ptr<TelemetrySubscriber>> Create(const Config& config, const std::string& key);
  ~TelemetrySubscriber();
  // Handles what arrives within `timeout`, at least one look; calls the handlers on this thread; an empty one
  // is skipped.
  void Poll(Duration timeout, const std::function<void(const ProcessStatus&)>& on_status,
            const std::function<void(const EpisodeReport&)>& on_episode);
  TelemetryRefusals refusals() const;

 private:
  TelemetrySubscriber() = default;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dadrl
