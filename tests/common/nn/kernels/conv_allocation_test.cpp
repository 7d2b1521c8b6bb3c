// A training step and an acting step must not touch the heap.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>

#include "tests/common/nn/kernels/conv_fixture.h"

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

namespace dadrl::nn::testing {
namespace {

TEST(ConvAllocationTest, NoCallAllocates) {
#if defined(DADRL_SANITIZED)
  GTEST_SKIP() << "the sanitizer owns malloc";
#endif
  const auto context = RandomImages(16, 61);
  const Tensors<float> params = RandomParams(62);
  const auto d_features = RandomFloats(16 * kConvFeatures, 63);
  for (Isa isa : AvailableIsas()) {
    const IsaScope scope(isa);
    SingleImageConvStack single;
    Arena arena(ConvStackActivationBytes(16, true));
    std::vector<float> features(16 * kConvFeatures);
    Tensors<float> grads;
    const long before = allocations;
    ConvStackForward(context.data(), 16, params.params(), arena.get(), features.data(), true);
    ConvStackBackward(context.data(), 16, params.params(), arena.get(), d_features.data(), grads.grads());
    single.Pack(params.params());
    single.Forward(context.data(), features.data());
    EXPECT_EQ(allocations, before) << IsaName(isa);
  }
}

TEST(ConvAllocationTest, TheCounterCounts) {
#if defined(DADRL_SANITIZED)
  GTEST_SKIP() << "the sanitizer owns malloc";
#endif
  const long before = allocations;
  const SingleImageConvStack single;
  EXPECT_GE(allocations - before, 2);
}

}  // namespace
}  // namespace dadrl::nn::testing
