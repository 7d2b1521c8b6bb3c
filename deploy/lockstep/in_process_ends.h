// The cluster's four seams as calls within one thread: experience into the table, batches out of it, policies
// across.
#pragma once

#include <cstdint>
#include <vector>

#include "actor/experience/chunking_sink.h"
#include "common/config/config.h"
#include "common/step/driving_shape.h"
#include "learner/batch_source.h"
#include "learner/policy_publisher.h"
#include "proto/experience.h"
#include "proto/trajectory_codec.h"
#include "replay/table.h"

namespace dadrl {

// Chunks go straight into the table. The first failure is kept and ends the training.
class TableSink final : public ChunkingSink {
 public:
  // Borrows `table`.
  TableSink(const Config& config, ReplayTable& table);
  bool blocked() const override { return false; }

  const Status& status() const { return status_; }

 private:
  void OnChunk(uint64_t sequence, std::vector<std::byte> bytes) override;

  ReplayTable& table_;
  Status status_;
};

// Batches straight from the table, through the same codec as over the network. The first failure is kept and
// ends the training.
class TableBatchSource final : public BatchSource {
 public:
  // Borrows `table`.
  TableBatchSource(const Config& config, const TrajectoryShape& shape, ReplayTable& table);
  // Null until the table may be sampled; never waits.
  TrajectoryBatch* Take(Duration timeout) override;
  void Release(TrajectoryBatch* batch) override;
  void UpdatePriorities(const TrajectoryBatch& batch, std::span<const float> td_error) override;
  Activity waiting_for() const override { return Activity::kWaitForInserts; }
  Status status() const override { return status_; }

 private:
  Status Fill();

  ReplayTable& table_;
  TrajectoryDecoder decoder_;
  TrajectoryBatch batch_;
  Status status_;
};

// Keeps the newest policy for the actor to take.
class PolicyRelay final : public PolicyPublisher, public PolicySource {
 public:
  void Publish(const PolicyUpdate& update) override;
  uint32_t TakeNewer(uint32_t have, std::vector<float>& parameters) override;

  const std::vector<float>& parameters() const { return parameters_; }

 private:
  uint32_t version_ = 0;
  std::vector<float> parameters_;
};

}  // namespace dadrl
