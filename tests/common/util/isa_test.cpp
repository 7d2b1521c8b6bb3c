#include "common/util/isa.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/common/util/isa_scope.h"

namespace dadrl {
namespace {

TEST(IsaTest, NamesRoundTrip) {
  for (Isa isa : {Isa::kScalar, Isa::kAvx2, Isa::kAvx512}) EXPECT_EQ(IsaFromName(IsaName(isa)), isa);
  EXPECT_EQ(IsaFromName("neon"), std::nullopt);
}

// In a process of its own, because the variable is read once.
int ChoiceUnder(const char* variable) {
  setenv("DADRL_ISA", variable, 1);
  std::exit(static_cast<int>(ActiveIsa()));
}

TEST(IsaDeathTest, EnvironmentChooses) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(ChoiceUnder("scalar"), ::testing::ExitedWithCode(static_cast<int>(Isa::kScalar)), "");
}

TEST(IsaDeathTest, UnknownNameInEnvironmentIsRefused) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(ChoiceUnder("sse9"), ::testing::ExitedWithCode(static_cast<int>(DetectIsa())), "");
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
}  // namespace dadrl
