// One replay shard as a process: the table, its two DDS sides, and what keeps it in order.
//
//   ingest thread   chunks -> table, acknowledgements; the only one that writes experience
//   server thread   requests -> batches, priorities
//   maintenance thread  what blocks on the disk: syncs, state, snapshots (maintenance.h)
//   caller of Run   what never blocks: commands, leases of actor numbers, telemetry, waits for the end
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "common/config/config.h"
#include "common/dds/node.h"
#include "common/port/port.h"
#include "common/util/clock.h"
#include "common/util/result.h"
#include "proto/status_envelope.h"
#include "proto/topics.h"
#include "replay/service/batch_server.h"
#include "replay/service/command_server.h"
#include "replay/service/ingest.h"
#include "replay/service/lease_server.h"
#include "replay/service/maintenance.h"
#include "replay/service/telemetry_relay.h"
#include "replay/table.h"

namespace dadrl {

class ReplayService {
 public:
  struct Options {
    Config config;
    std::filesystem::path run_directory;
    uint32_t shard = 0;
    uint64_t incarnation = 0;
  };

  // Recovers the shard's experience from <run_directory>/replay/shard-K, then joins the cluster; where
  // nothing can be written, to serve what is there. One line says what is wrong when it cannot: port taken,
  // folder not there and not to be made, other schema.
  static Result<std::unique_ptr<ReplayService>> Create(const Options& options, Clock& clock);

  // Serves until `stop`; then takes what has arrived, forces it to the device and writes its state. Call
  // once.
  Status Run(const std::atomic<bool>& stop);

  const ReplayTable& table() const { return *table_; }

 private:
  ReplayService(const Options& options, Clock& clock) : options_(options), clock_(clock) {}
  Status Join();
  Status AnnounceRun();
  Status OpenLeases();
  void PublishState(bool ending);
  void PublishStatus();

  const Options options_;
  Clock& clock_;
  TimePoint started_{};
  std::unique_ptr<ReplayTable> table_;
  std::unique_ptr<dds::Node> node_;  // outlives the endpoints below
  std::unique_ptr<BatchServer> server_;
  std::unique_ptr<Ingest> ingest_;
  std::unique_ptr<Maintenance> maintenance_;
  std::unique_ptr<CommandServer> commands_;
  // Shard 0's: for who joins, and for who is out of LCM's reach.
  std::unique_ptr<Writer<dadrl_idl_RunConfig>> run_config_;
  std::unique_ptr<Writer<dadrl_idl_RunState>> run_state_;
  std::unique_ptr<LeaseServer> leases_;
  std::unique_ptr<TelemetryRelay> relay_;
  std::unique_ptr<TelemetryPublisher> telemetry_;
  std::optional<StatusEnvelope> envelope_;
};

// Resident memory of this process, bytes; 0 where /proc is not there.
uint64_t ResidentBytes();

}  // namespace dadrl
