// A batch of transitions as the learner receives it.
#include "proto/sample_batch.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "tests/fuzz/harness.h"
#include "tests/proto/synthetic_experience.h"

namespace dadrl::fuzz {
namespace {

const ObservationSpec kSpec;
const ExperienceBounds kBounds = ExperienceBounds::From(Config{});
constexpr int kBatchSize = 3;
constexpr double kGamma = 0.99;

bool AllWithin(const std::vector<float>& values, double bound) {
  return std::ranges::all_of(values, [&](float value) { return std::abs(value) <= bound; });
}

}  // namespace

const int kMutants = 60000;

bool Check(std::span<std::byte> input) {
  static FrameCodec codec(kSpec, FloatCoding::kFloat16);
  static TransitionBatch batch(kSpec, kBatchSize);
  const std::span<const std::byte> bytes = MendedIfAsked(input);
  if (!DecodeSampleBatch(bytes, SchemaHash(kSpec), kGamma, kBounds, codec, batch)) return false;
  Require(AllWithin(batch.reward, kMaxSliceSteps * kBounds.reward));
  for (const auto* shares : {&batch.discount, &batch.weight, &batch.action}) Require(AllWithin(*shares, 1.0));
  for (const auto* observation : {&batch.observation, &batch.next_observation}) {
    Require(AllWithin(observation->vehicles, ObservationSpec::kFeatureBound));
    Require(AllWithin(observation->ego, ObservationSpec::kFeatureBound));
  }
  return true;
}

Seeds MakeSeeds() {
  const auto chunk =
      MakeSyntheticChunk(kSpec, {.identity = {1, 2, 4}, .frames = 2, .end = kTruncated, .final_frame = true});
  const auto view = ChunkView::Parse(chunk).value();
  const auto batch = [&](std::vector<float> rewards) {
    std::vector<SampledItem> items(kBatchSize);
    for (SampledItem& item : items) {
      item.rewards = rewards;
      item.first = view.payload(0);
      item.next = view.payload(2);
    }
    items[1].terminated = true;
    items[1].next = {};
    return AskMended(EncodeSampleBatch(items, SchemaHash(kSpec)));
  };
  return {.accepted = {batch({1.0f, 2.0f})},
          .refused = {batch({1.0f, 1e30f}), batch({3e38f, 3e38f}), batch({3e38f, -3e38f})}};
}

}  // namespace dadrl::fuzz
