// From drawn items to the batch that is sent: n-step slices across chunk borders, read outside the table's
// lock.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/util/result.h"
#include "proto/experience.h"
#include "proto/sample_batch.h"
#include "proto/sequence_batch.h"
#include "replay/storage/segment.h"

namespace dadrl {

// What was drawn, with a hold on the segments behind it: these may leave the table meanwhile.
struct DrawnItems {
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

// A batch, its memory and its hold. Movable; `items` stay valid.
struct SampledBatch {
  std::vector<SampledItem> items;
  std::vector<float> rewards;
  std::vector<std::shared_ptr<const Segment>> segments;
};

// Reads rewards, ends and payloads of `n_step` steps from each item on. kCorrupt: the stored bytes changed
// since they were checked (a failing disk); nothing is read outside them.
Result<SampledBatch> AssembleBatch(DrawnItems drawn, int n_step);

// The same for sequences of up to `length` decisions, which end with their episode.
struct SampledSequences {
  std::vector<SampledSequence> sequences;
  std::vector<std::shared_ptr<const Segment>> segments;
};
Result<SampledSequences> AssembleSequences(DrawnItems drawn, int length);

// After everything was read: kCorrupt when something of it could not be (ReplayTable::DropDamaged).
Status CheckReadable(const std::vector<std::shared_ptr<const Segment>>& segments);

}  // namespace dadrl
