#include "replay/trajectory_reader.h"

#include <utility>

namespace dadrl {
namespace {

// A position in an episode, over the chunks of one item.
struct Cursor {
  std::span<const ChunkView> chunks;
  int frame = 0;

  const ChunkView& chunk() const { return chunks.front(); }
  uint8_t flags() const { return chunk().flags(frame); }
  bool is_final() const { return (flags() & kHasDecision) == 0; }
  bool Advance() {
    if (++frame < chunk().frames()) return true;
    chunks = chunks.subspan(1);
    frame = 0;
    return !chunks.empty();
  }
};

// False when the offsets do not fit the chunk: it was sound when it was stored.
bool ReadPayload(const Cursor& at, SampledBatch& batch) {
  const uint32_t begin = at.chunk().offset(at.frame);
  const uint32_t end = at.chunk().offset(at.frame + 1);
  if (begin >= end || end > at.chunk().payload_bytes()) return false;
  batch.payloads.push_back(at.chunk().payload(at.frame));
  // It reads the offsets anew: a failing disk may change them at any time.
  return batch.payloads.back().size() == end - begin;
}

// Appends what the trajectory at `at` holds to the batch's steps and payloads; false when the stored bytes
// make none.
bool ReadSteps(Cursor at, const TrajectoryShape& shape, SampledTrajectory& trajectory, SampledBatch& batch) {
  for (int step = 0; step < shape.steps; ++step) {
    if (at.is_final()) return false;
    if ((step == 0 || shape.all_observations) && !ReadPayload(at, batch)) return false;
    const ChunkView& chunk = at.chunk();
    batch.steps.push_back({chunk.policy_version(at.frame), chunk.reward(at.frame), chunk.decision(at.frame)});
    trajectory.terminated = (at.flags() & kTerminated) != 0;
    trajectory.truncated = (at.flags() & kTruncated) != 0;
    if (trajectory.terminated) return true;
    if (!at.Advance() || at.is_final() != trajectory.truncated) return false;
    if (trajectory.truncated) break;
  }
  return ReadPayload(at, batch);
}

}  // namespace

Result<SampledBatch> ReadTrajectories(SampledItems sampled, const TrajectoryShape& shape) {
  SampledBatch batch;
  batch.segments = std::move(sampled.segments);
  batch.trajectories.resize(sampled.items.size());
  // Neither grows beyond this, so the trajectories' spans stay where they are.
  batch.steps.reserve(sampled.items.size() * static_cast<size_t>(shape.steps));
  batch.payloads.reserve(sampled.items.size() * static_cast<size_t>(shape.observations()));
  const std::span<const ChunkView> chunks(sampled.chunks);
  // Most of it is not in the processor's caches: ask for all before any of it is read.
  for (const SampledItems::Item& item : sampled.items) chunks[item.first_chunk].PrefetchColumns(item.frame);
  for (size_t i = 0; i < sampled.items.size(); ++i) {
    const SampledItems::Item& from = sampled.items[i];
    SampledTrajectory& trajectory = batch.trajectories[i];
    trajectory.key = from.key;
    trajectory.probability = from.probability;
    trajectory.importance_weight = from.importance_weight;
    const size_t first_step = batch.steps.size();
    const size_t first_payload = batch.payloads.size();
    const Cursor start{chunks.subspan(from.first_chunk, from.chunk_count), from.frame};
    if (!ReadSteps(start, shape, trajectory, batch)) {
      return Fail(ErrorCode::kCorrupt,
                  "stored frame {:#x} has changed since it was checked: the disk is failing", from.key);
    }
    trajectory.steps = std::span(batch.steps).subspan(first_step);
    trajectory.payloads = std::span(batch.payloads).subspan(first_payload);
  }
  return batch;
}

Status CheckReadable(const std::vector<std::shared_ptr<const Segment>>& segments) {
  for (const auto& segment : segments) {
    if (segment->damaged()) return Fail(ErrorCode::kCorrupt, "cannot read {}", segment->path().string());
  }
  return {};
}

}  // namespace dadrl
