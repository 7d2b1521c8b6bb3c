// Everything that a learner process owns but the network: algorithm, trainer, checkpoints in a folder.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <vector>

#include "learner/checkpoint_store.h"
#include "learner/resume.h"
#include "learner/trainer.h"
#include "tests/learner/fake_algorithm.h"
#include "tests/learner/memory_batch_source.h"

namespace dadrl {

class RecordingPublisher final : public PolicyPublisher {
 public:
  void Publish(const PolicyUpdate& update) override { versions.push_back(update.version); }
  std::vector<uint32_t> versions;
};

// One life of a learner; `first_batch` is where its experience goes on.
struct TestLearner {
  TestLearner(const Config& config, const std::filesystem::path& directory, bool resume,
              uint64_t first_batch = 0, std::unique_ptr<Algorithm> given = std::make_unique<FakeAlgorithm>(),
              Duration (*cpu_time)() = ProcessCpuTime)
      : algorithm(std::move(given)), batches(16, first_batch) {
    CheckpointStore store = CheckpointStore::Open(directory, Retention::Of(config)).value();
    auto begun = BeginTraining(config, store, 0, resume, *algorithm);
    if (!begun) {
      error = begun.error();
      return;
    }
    checkpoints = std::make_unique<CheckpointWriter>(std::move(store), clock);
    trainer = std::make_unique<Trainer>(
        config, Trainer::Parts{*algorithm, batches, publisher, *checkpoints, clock, PausedTime, cpu_time},
        *begun);
  }
  void Steps(int count) {
    for (int i = 0; i < count; ++i) {
      const auto step = trainer->RunStep(Duration::zero());
      ASSERT_TRUE(step) << step.error().message;
      ASSERT_EQ(*step, Trainer::Step::kUpdated);
    }
  }
  FakeAlgorithm& fake() { return dynamic_cast<FakeAlgorithm&>(*algorithm); }

  std::unique_ptr<Algorithm> algorithm;
  MemoryBatchSource batches;
  RecordingPublisher publisher;
  ManualClock clock;
  Error error;  // why there is no trainer
  std::unique_ptr<CheckpointWriter> checkpoints;
  std::unique_ptr<Trainer> trainer;
};

}  // namespace dadrl
