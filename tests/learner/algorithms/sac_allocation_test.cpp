// A training step and an acting step must not touch the heap.
#include <atomic>
#include <cstdlib>

#include "common/model/acting_policy.h"
#include "tests/learner/algorithms/sac_fixture.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define DADRL_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define DADRL_SANITIZED
#endif
#endif

namespace {
std::atomic<long> allocations{0};
}

#if !defined(DADRL_SANITIZED)  // which replace malloc themselves
extern "C" {
void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* old, size_t size);
void* __libc_memalign(size_t alignment, size_t size);

void* malloc(size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(size_t count, size_t size) {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* old, size_t size) {
  ++allocations;
  return __libc_realloc(old, size);
}
void* aligned_alloc(size_t alignment, size_t size) {
  ++allocations;
  return __libc_memalign(alignment, size);
}
}
#endif

namespace dadrl {
namespace {

class AllocationTest : public testing::Test {
 protected:
  void SetUp() override {
#if defined(DADRL_SANITIZED)
    GTEST_SKIP() << "the sanitizer owns malloc";
#endif
  }
};

TEST_F(AllocationTest, UpdateAllocatesNothingAfterTheFirst) {
  for (const EncoderSharing encoders : {EncoderSharing::kSeparate, EncoderSharing::kShared}) {
    for (const int threads : {1, 2}) {
      Config config;
      config.model.encoders = encoders;
      config.algorithm.batch_size = 40;
      config.learner.threads = threads;
      Sac sac(config);
      const TransitionBatch batch = AnyBatch(ObservationSpec{}, 40, 1);
      ASSERT_TRUE(sac.Update(batch));
      const long before = allocations;
      bool updated = true;
      for (int i = 0; i < 3; ++i) updated = updated && sac.Update(batch).has_value();
      const long after = allocations;
      EXPECT_TRUE(updated);
      EXPECT_EQ(after, before) << threads << " threads";
    }
  }
}

TEST_F(AllocationTest, ActAllocatesNothing) {
  const ObservationSpec spec;
  const ModelConfig model;
  ActingPolicy policy(spec, model);
  ASSERT_TRUE(policy.Load(std::vector<float>(policy.parameter_count(), 0.01f)));
  const Observation observation(spec);
  Random random(1);
  const long before = allocations;
  policy.Act(observation, &random);
  policy.Act(observation, nullptr);
  EXPECT_EQ(allocations, before);
}

TEST_F(AllocationTest, TheCounterCounts) {
  const long before = allocations;
  const Sac sac{Config{}};
  EXPECT_GT(allocations, before);
}

}  // namespace
}  // namespace dadrl
