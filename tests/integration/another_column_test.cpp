// Another column of the observation (docs/extending.md), from a sensor to a gradient: no file between the two
// knows of it.
#include <gtest/gtest.h>

#include <cmath>

#include "common/step/driving_shape.h"
#include "proto/trajectory_codec.h"
#include "replay/table.h"
#include "tests/proto/synthetic_experience.h"

namespace dadrl {
namespace {

// The line of the spec.
StepSpec WithTheGap() {
  StepSpec spec = DrivingStepSpec(DrivingShape{});
  spec.observation.push_back({.name = "gap", .bound = 1.0f});
  return spec;
}

// The sensor: distance to the nearest vehicle ahead in the ego's lane, / 30 m; 1 when there is none.
float GapAhead(std::span<const float> vehicles, const DrivingShape& shape) {
  const auto length = static_cast<size_t>(shape.history * DrivingShape::kVehicleFeatures);
  float gap = 1.0f;
  for (size_t v = 0; v < static_cast<size_t>(shape.vehicles); ++v) {
    const auto now = vehicles.subspan((v + 1) * length - DrivingShape::kVehicleFeatures);
    const bool ahead = now[0] < 0.5f && now[1] > 0.0f && std::abs(now[2]) < 1.6f / 30.0f;
    if (ahead) gap = std::min(gap, std::hypot(now[1], now[2]));
  }
  return gap;
}

// The network: value = weight * gap + bias, towards the reward.
class GapValue {
 public:
  explicit GapValue(const StepSpec& spec)
      : column_(FindColumn(spec.observation, "gap", ElementType::kFloat32, 0).value()) {}
  // The mean square before a step of gradient descent.
  float Update(const TrajectoryBatch& batch) {
    const std::span<const float> gaps = batch.ObservationsAt(0).floats(column_);
    float loss = 0.0f, weight_gradient = 0.0f, bias_gradient = 0.0f;
    const auto scale = 1.0f / static_cast<float>(gaps.size());
    for (size_t i = 0; i < gaps.size(); ++i) {
      const float error = weight_ * gaps[i] + bias_ - batch.rewards[i];
      loss += scale * error * error;
      weight_gradient += scale * 2.0f * error * gaps[i];
      bias_gradient += scale * 2.0f * error;
    }
    weight_ -= 0.5f * weight_gradient;
    bias_ -= 0.5f * bias_gradient;
    return loss;
  }

 private:
  size_t column_;
  float weight_ = 0.0f;
  float bias_ = 0.0f;
};

TEST(AnotherColumn, IsSensedStoredSampledAndLearntFrom) {
  const StepSpec spec = WithTheGap();
  const DrivingShape shape = DrivingShape::Find(spec).value();
  const SystemClock clock;
  TableOptions options{.directory = {}, .spec = spec, .replay = {}, .n_step = 1};
  options.replay.min_size = 1;
  options.replay.samples_per_insert = 0.0;
  const auto table = ReplayTable::Open(options, clock).value();

  Random random(3);
  ChunkBuilder builder(spec, FloatCoding::kFloat16);
  Observation observation(spec);
  const size_t column = spec.observation.size() - 1;
  for (uint64_t sequence = 1; sequence <= 8; ++sequence) {
    builder.Begin(sequence, 0);
    for (int i = 0; i < 64; ++i) {
      const Observation seen = SyntheticObservation(shape, random);
      for (size_t c = 0; c < seen.columns(); ++c) {
        std::ranges::copy(seen.floats(c), observation.floats(c).begin());
        std::ranges::copy(seen.bits(c), observation.bits(c).begin());
      }
      const float gap = GapAhead(observation.floats(shape.vehicles_column), shape);
      observation.floats(column)[0] = gap;
      builder.AddTransition(observation, Action{}, 2.0f * gap - 0.5f, i == 63 ? kTerminated : uint8_t{0}, 1);
    }
    ASSERT_EQ(table->Insert(builder.Finish({1, 1, sequence})), ReplayTable::Insertion::kStored);
  }

  const TrajectoryShape batch_shape{.count = 128};
  TrajectoryDecoder decoder(spec, ExperienceBounds::From(Config{}));
  TrajectoryBatch batch(spec, batch_shape);
  GapValue value(spec);
  float loss = 1.0f;
  for (int update = 0; update < 300; ++update) {
    const SampledBatch sampled = table->Sample(batch_shape, 1).value();
    ASSERT_TRUE(
        decoder.Decode(EncodeTrajectories(sampled.trajectories, batch_shape, table->schema()), batch));
    loss = value.Update(batch);
  }
  EXPECT_LT(loss, 1e-3f);
}

TEST(AnotherColumn, ARunWithoutItIsRefusedWithBothLists) {
  const StepSpec without = DrivingStepSpec(DrivingShape{});
  EXPECT_NE(SchemaHash(without), SchemaHash(WithTheGap()));
  const auto found = FindColumn(without.observation, "gap", ElementType::kFloat32, 0);
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().message.find("'gap'"), std::string::npos);
  EXPECT_NE(found.error().message.find("ego float32 [5, 20]"), std::string::npos);
}

}  // namespace
}  // namespace dadrl
