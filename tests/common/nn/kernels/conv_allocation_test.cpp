// A training step and an acting step must not touch the heap.
#include <gtest/gtest.h>

#include "tests/common/allocation_counter.h"
#include "tests/common/nn/kernels/conv_fixture.h"

namespace dadrl::nn::testing {
namespace {

using dadrl::testing::Allocations;

class ConvAllocationTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!dadrl::testing::CountsAllocations()) GTEST_SKIP() << "the sanitizer owns malloc";
  }
};

TEST_F(ConvAllocationTest, NoCallAllocates) {
  const auto context = RandomImages(16, 61);
  const Tensors<float> params = RandomParams(62);
  const auto d_features = RandomFloats(16 * kConvFeatures, 63);
  for (Isa isa : AvailableIsas()) {
    const IsaScope scope(isa);
    SingleImageConvStack single;
    Arena arena(ConvStackActivationBytes(16, true));
    std::vector<float> features(16 * kConvFeatures);
    Tensors<float> grads;
    const long before = Allocations();
    ConvStackForward(context.data(), 16, params.params(), arena.get(), features.data(), true);
    ConvStackBackward(context.data(), 16, params.params(), arena.get(), d_features.data(), grads.grads());
    single.Pack(params.params());
    single.Forward(context.data(), features.data());
    EXPECT_EQ(Allocations(), before) << IsaName(isa);
  }
}

TEST_F(ConvAllocationTest, TheCounterCounts) {
  const long before = Allocations();
  const SingleImageConvStack single;
  EXPECT_GE(Allocations() - before, 2);
}

}  // namespace
}  // namespace dadrl::nn::testing
