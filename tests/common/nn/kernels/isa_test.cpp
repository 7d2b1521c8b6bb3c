#include "common/nn/kernels/isa.h"

#include <gtest/gtest.h>

#include "tests/common/nn/kernels/conv_fixture.h"

namespace dadrl::nn::testing {
namespace {

TEST(IsaTest, NamesRoundTrip) {
  for (Isa isa : {Isa::kScalar, Isa::kAvx2, Isa::kAvx512}) EXPECT_EQ(IsaFromName(IsaName(isa)), isa);
  EXPECT_EQ(IsaFromName("neon"), std::nullopt);
}

TEST(IsaTest, SwitchesToWhatTheProcessorHasAndNothingElse) {
  const IsaScope scope(ActiveIsa());
  for (Isa isa : {Isa::kScalar, Isa::kAvx2, Isa::kAvx512}) {
    const Isa before = ActiveIsa();
    EXPECT_EQ(SetIsa(isa), isa <= DetectIsa());
    EXPECT_EQ(ActiveIsa(), isa <= DetectIsa() ? isa : before);
  }
}

}  // namespace
}  // namespace dadrl::nn::testing
