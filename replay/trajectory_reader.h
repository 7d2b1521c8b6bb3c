// From sampled items to the trajectories that are sent: across chunk borders, read outside the table's lock.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/step/trajectory_batch.h"
#include "common/util/result.h"
#include "proto/experience.h"
#include "proto/trajectory_codec.h"
#include "replay/storage/segment.h"

namespace dadrl {

// What was sampled, with a hold on the segments behind it: these may leave the table meanwhile.
struct SampledItems {
  struct Item {
    uint64_t key = 0;
    int frame = 0;           // within its first chunk
    size_t first_chunk = 0;  // in `chunks`; the episode's following chunks stand behind it
    size_t chunk_count = 0;
    float probability = 1.0f;
    float importance_weight = 1.0f;
  };
  std::vector<Item> items;
  std::vector<ChunkView> chunks;
  // Shared: the log may drop a segment while a batch is being sent from it.
  std::vector<std::shared_ptr<const Segment>> segments;
};

// Trajectories, their memory and their hold. Movable; what they borrow stays valid.
struct SampledBatch {
  std::vector<SampledTrajectory> trajectories;
  std::vector<SampledStep> steps;
  std::vector<std::span<const std::byte>> payloads;
  std::vector<std::shared_ptr<const Segment>> segments;
};

// Reads up to `shape.steps` steps from each item on, fewer where the episode ends, and the payloads that the
// shape asks for. kCorrupt: the stored bytes changed since they were checked (a failing disk); nothing is
// read outside them.
Result<SampledBatch> ReadTrajectories(SampledItems sampled, const TrajectoryShape& shape);

// After everything was read: kCorrupt when something of it could not be (ReplayTable::DropDamaged).
Status CheckReadable(const std::vector<std::shared_ptr<const Segment>>& segments);

}  // namespace dadrl
