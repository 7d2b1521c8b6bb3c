// A batch of sequences as a recurrent learner receives it.
#include "proto/sequence_batch.h"

#include <algorithm>
#include <cmath>

#include "tests/fuzz/harness.h"
#include "tests/proto/synthetic_experience.h"

namespace dadrl::fuzz {
namespace {

const ObservationSpec kSpec;
const ExperienceBounds kBounds = ExperienceBounds::From(Config{});
constexpr int kBatchSize = 3;
constexpr int kLength = 2;

bool AllWithin(const std::vector<float>& values, double bound) {
  return std::ranges::all_of(values, [&](float value) { return std::abs(value) <= bound; });
}

void CheckShape(const SequenceBatch& batch, size_t i) {
  const int steps = batch.steps[i];
  const bool ended = batch.terminated[i] != 0 || batch.truncated[i] != 0;
  Require(steps >= 1 && steps <= kLength && (ended || steps == kLength));
  Require(batch.terminated[i] == 0 || batch.truncated[i] == 0);
  for (auto behind = static_cast<size_t>(steps); behind < kLength; ++behind) {
    Require(batch.reward[i * kLength + behind] == 0.0f);
  }
}

// One that goes on, one cut short by a termination, one that is truncated.
Bytes Batch(const ChunkView& ended, const ChunkView& truncated, float reward) {
  std::vector<SampledSequence> sequences(kBatchSize);
  sequences[0].steps.resize(2);
  sequences[0].steps[1].reward = reward;
  sequences[0].frames = {ended.payload(0), ended.payload(1), ended.payload(2)};
  sequences[1].terminated = true;
  sequences[1].steps.resize(1);
  sequences[1].frames = {ended.payload(2)};
  sequences[2].truncated = true;
  sequences[2].steps.resize(2);
  sequences[2].frames = {truncated.payload(0), truncated.payload(1), truncated.payload(2)};
  const Bytes bytes = EncodeSequenceBatch(sequences, kLength, SchemaHash(kSpec));
  Require(bytes.size() == SequenceBatchBytes(sequences));
  return AskMended(bytes);
}

}  // namespace

const int kMutants = 60000;

bool Check(std::span<std::byte> input) {
  static FrameCodec codec(kSpec, FloatCoding::kFloat16);
  static SequenceBatch batch(kSpec, kBatchSize, kLength);
  const std::span<const std::byte> bytes = MendedIfAsked(input);
  if (!DecodeSequenceBatch(bytes, SchemaHash(kSpec), kBounds, codec, batch)) return false;
  Require(AllWithin(batch.reward, kBounds.reward));
  Require(AllWithin(batch.weight, 1.0) && AllWithin(batch.action, 1.0));
  Require(AllWithin(batch.observation.ego, ObservationSpec::kFeatureBound));
  Require(AllWithin(batch.observation.vehicles, ObservationSpec::kFeatureBound));
  for (size_t i = 0; i < kBatchSize; ++i) CheckShape(batch, i);
  return true;
}

Seeds MakeSeeds() {
  const auto ended = MakeSyntheticChunk(kSpec, {.identity = {1, 2, 3}, .frames = 3, .end = kTerminated});
  const auto truncated =
      MakeSyntheticChunk(kSpec, {.identity = {1, 2, 4}, .frames = 2, .end = kTruncated, .final_frame = true});
  const ChunkView first = ChunkView::Parse(ended).value();
  const ChunkView second = ChunkView::Parse(truncated).value();
  return {.accepted = {Batch(first, second, 1.0f)},
          .refused = {Batch(first, second, 1e30f), Batch(first, second, 3e38f)}};
}

}  // namespace dadrl::fuzz
