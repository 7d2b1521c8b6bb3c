// What recorded driving takes in the replay.
#include <gtest/gtest.h>

#include <atomic>

#include "actor/collect/collector.h"
#include "actor/environment.h"
#include "actor/experience/chunking_sink.h"
#include "common/step/step_spec_of.h"
#include "replay/table.h"
#include "tests/replay/test_chunks.h"

namespace dadrl {
namespace {

class TableSink final : public ChunkingSink {
 public:
  TableSink(const Config& config, ReplayTable& table) : ChunkingSink(config, 0, 1), table_(table) {}
  bool blocked() const override { return false; }

 private:
  void OnChunk(uint64_t, std::vector<std::byte> bytes) override {
    EXPECT_EQ(table_.Insert(bytes).value(), ReplayTable::Insertion::kStored);
  }
  ReplayTable& table_;
};

class NoPolicies final : public PolicySource {
 public:
  uint32_t TakeNewer(uint32_t, std::vector<float>&) override { return 0; }
};

TEST(Compactness, ALeftTurnTakesLessThanEightHundredBytesAFrameAllTold) {
  constexpr uint64_t kFrames = 2000;
  const Config config;  // left_turn, at random until a policy comes
  const TemporaryFolder folder;
  SystemClock clock;
  TimeLedger ledger(clock);
  const std::atomic<bool> stop{false};
  auto table = ReplayTable::Open({.directory = folder.path(),
                                  .spec = StepSpecOf(config),
                                  .replay = config.replay,
                                  .n_step = config.algorithm.n_step},
                                 clock)
                   .value();
  const auto environment = MakeDrivingEnvironment(config).value();
  TableSink sink(config, *table);
  NoPolicies none;
  const auto policy = MakePolicyModel(DrivingShape::From(config.observation), config.model).value();
  Collector collector(config,
                      {.environment = *environment,
                       .sink = sink,
                       .policies = none,
                       .policy = *policy,
                       .ledger = ledger,
                       .clock = clock,
                       .stop = stop},
                      0, 0);
  while (table->stats().frames_held < kFrames) {
    ASSERT_TRUE(collector.RunEpisode());
  }
  const ReplayTable::Stats stats = table->stats();
  const auto frames = static_cast<double>(stats.frames_held);
  const double disk = static_cast<double>(stats.disk_bytes) / frames;
  const double index = static_cast<double>(stats.index_bytes) / frames;
  RecordProperty("disk_bytes_per_frame", std::to_string(disk));
  RecordProperty("index_bytes_per_frame", std::to_string(index));
  EXPECT_LT(disk + index, 800.0);
  EXPECT_GT(disk, 100.0) << "a frame cannot be that small: is it stored at all?";
}

}  // namespace
}  // namespace dadrl
