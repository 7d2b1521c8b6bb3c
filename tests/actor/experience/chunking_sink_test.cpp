#include "actor/experience/chunking_sink.h"

#include <gtest/gtest.h>

#include "common/step/driving_shape.h"
#include "common/util/random.h"
#include "tests/driving_columns.h"

namespace dadrl {
namespace {

class Chunks final : public ChunkingSink {
 public:
  explicit Chunks(const Config& config) : ChunkingSink(config, 7, 100) {}
  bool blocked() const override { return false; }
  std::vector<std::vector<std::byte>> all;

 private:
  void OnChunk(uint64_t sequence, std::vector<std::byte> bytes) override {
    EXPECT_EQ(sequence, all.size() + 1);
    all.push_back(std::move(bytes));
  }
};

// Frames so large that the bytes of a chunk end it, not their number.
TEST(ChunkingSink, CutsBeforeAChunkOfLargeObservationsIsTooLongForTheWire) {
  Config config;
  config.observation.vehicles = 600;
  config.observation.history = 8;
  config.actor.floats = FloatCoding::kFloat32;
  config.actor.chunk_frames = kMaxChunkFrames;
  Random random(3);
  Observation observation(DrivingShape::From(config.observation));
  for (float& value : VehiclesOf(observation)) value = static_cast<float>(random.Uniform());
  constexpr uint32_t kFrames = 100;
  Chunks chunks(config);
  chunks.BeginEpisode(1);
  for (uint32_t i = 0; i + 1 < kFrames; ++i) {
    chunks.AddTransition(observation, Action{}, 0.0f, i + 2 == kFrames ? kTruncated : 0, 1);
  }
  chunks.AddFinal(observation);
  chunks.EndEpisode();
  uint32_t next = 0;
  for (const std::vector<std::byte>& bytes : chunks.all) {
    const auto view = ChunkView::Parse(bytes);
    ASSERT_TRUE(view) << view.error().message;
    EXPECT_LT(view->frames(), kMaxChunkFrames);
    EXPECT_EQ(view->header().first_frame, next);
    next += view->header().frames;
  }
  EXPECT_EQ(next, kFrames);
}

}  // namespace
}  // namespace dadrl
