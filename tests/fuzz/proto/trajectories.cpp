// A batch of trajectories as the learner receives it, with the ends or all of their observations.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "proto/experience.h"
#include "proto/trajectory_codec.h"
#include "tests/driving_columns.h"
#include "tests/fuzz/harness.h"
#include "tests/proto/synthetic_experience.h"

namespace dadrl::fuzz {
namespace {

const DrivingShape kSpec;
const ExperienceBounds kBounds = ExperienceBounds::From(Config{});
constexpr TrajectoryShape kEnds{3, 2, false};
constexpr TrajectoryShape kAll{3, 2, true};

bool AllWithin(std::span<const float> values, double bound) {
  return std::ranges::all_of(values, [&](float value) { return std::abs(value) <= bound; });
}

void CheckBatch(const TrajectoryBatch& batch) {
  Require(AllWithin(batch.rewards, kBounds.reward));
  Require(AllWithin(batch.weights, 1.0) && AllWithin(batch.decisions[0], 1.0));
  Require(AllWithin(VehiclesOf(batch.observations), DrivingShape::kFeatureBound));
  Require(AllWithin(EgoOf(batch.observations), DrivingShape::kFeatureBound));
  for (size_t i = 0; i < batch.steps.size(); ++i) {
    Require(batch.steps[i] >= 1 && batch.steps[i] <= batch.shape.steps);
    Require(batch.steps[i] == batch.shape.steps || batch.terminated[i] != 0 || batch.truncated[i] != 0);
    Require(batch.terminated[i] == 0 || batch.truncated[i] == 0);
  }
}

}  // namespace

const int kMutants = 60000;

bool Check(std::span<std::byte> input) {
  static TrajectoryDecoder decoder(kSpec, kBounds);
  static TrajectoryBatch ends(kSpec, kEnds);
  static TrajectoryBatch all(kSpec, kAll);
  const std::span<const std::byte> bytes = MendedIfAsked(input);
  bool taken = false;
  for (TrajectoryBatch* batch : {&ends, &all}) {
    if (!decoder.Decode(bytes, *batch)) continue;
    CheckBatch(*batch);
    taken = true;
  }
  return taken;
}

Seeds MakeSeeds() {
  const auto chunk =
      MakeSyntheticChunk(kSpec, {.identity = {1, 2, 4}, .frames = 2, .end = kTruncated, .final_frame = true});
  const auto view = ChunkView::Parse(chunk).value();
  const auto batch = [&](const TrajectoryShape& shape, float first, float second) {
    const SampledStep steps[] = {{1, first, view.decision(0)}, {1, second, view.decision(1)}};
    std::vector<std::span<const std::byte>> payloads = {view.payload(0), view.payload(2)};
    if (shape.all_observations) payloads.insert(payloads.begin() + 1, view.payload(1));
    std::vector<SampledTrajectory> trajectories(static_cast<size_t>(shape.count),
                                                {.truncated = true, .steps = steps, .payloads = payloads});
    trajectories[1].truncated = false;
    trajectories[1].terminated = true;
    trajectories[1].payloads = std::span(payloads).first(payloads.size() - 1);
    return AskMended(EncodeTrajectories(trajectories, shape, SchemaHash(kSpec)));
  };
  return {.accepted = {batch(kEnds, 1.0f, 2.0f), batch(kAll, 1.0f, 2.0f)},
          .refused = {batch(kEnds, 1.0f, 1e30f), batch(kEnds, 3e38f, 3e38f), batch(kAll, 3e38f, -3e38f)}};
}

}  // namespace dadrl::fuzz
