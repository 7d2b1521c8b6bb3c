// A training step and an acting step must not touch the heap.
#include "common/model/policy_model.h"
#include "tests/common/allocation_counter.h"
#include "tests/learner/algorithms/sac_fixture.h"

namespace dadrl {
namespace {

using testing::Allocations;

class AllocationTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!testing::CountsAllocations()) GTEST_SKIP() << "the sanitizer owns malloc";
  }
};

TEST_F(AllocationTest, UpdateAllocatesNothingAfterTheFirst) {
  for (const EncoderSharing encoders : {EncoderSharing::kSeparate, EncoderSharing::kShared}) {
    for (const auto& [threads, shift_pixels] : {std::pair(1, 0), {2, 0}, {2, 2}}) {
      Config config;
      config.algorithm.shift_pixels = shift_pixels;
      config.model.encoders = encoders;
      config.algorithm.batch_size = 40;
      config.learner.threads = threads;
      Sac sac(config);
      const TransitionBatch batch = AnyBatch(DrivingShape{}, 40, 1);
      ASSERT_TRUE(sac.Update(batch));
      const long before = Allocations();
      bool updated = true;
      for (int i = 0; i < 3; ++i) updated = updated && sac.Update(batch).has_value();
      const long after = Allocations();
      EXPECT_TRUE(updated);
      EXPECT_EQ(after, before) << threads << " threads";
    }
  }
}

TEST_F(AllocationTest, ActAllocatesNothing) {
  const DrivingShape spec;
  const auto policy = MakePolicyModel(spec, {}).value();
  ASSERT_TRUE(policy->Load(std::vector<float>(policy->layout().size(), 0.01f)));
  const Observation observation(spec);
  Random random(1);
  const long before = Allocations();
  policy->Act(observation, &random);
  policy->Act(observation, nullptr);
  EXPECT_EQ(Allocations(), before);
}

TEST_F(AllocationTest, TheCounterCounts) {
  const long before = Allocations();
  const Sac sac{Config{}};
  EXPECT_GT(Allocations(), before);
}

}  // namespace
}  // namespace dadrl
