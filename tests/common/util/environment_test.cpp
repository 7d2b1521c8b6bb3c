#include "common/util/environment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "common/util/shown.h"

namespace dadrl {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(Environment, UnsetAndEmptyAreTheSame) {
  unsetenv("DADRL_SCENARIOS");
  EXPECT_FALSE(FromEnvironment(kScenariosVariable));
  EXPECT_EQ(FolderRemedy(kScenariosVariable, "build it"), "build it");
  setenv("DADRL_SCENARIOS", "", 1);
  EXPECT_FALSE(FromEnvironment(kScenariosVariable));
  setenv("DADRL_SCENARIOS", "/roads", 1);
  EXPECT_EQ(FromEnvironment(kScenariosVariable), "/roads");
  EXPECT_THAT(FolderRemedy(kScenariosVariable, "build it"), HasSubstr("DADRL_SCENARIOS names this folder"));
  unsetenv("DADRL_SCENARIOS");
}

TEST(Environment, VariablesThatNobodyReadsAreNamed) {
  const char* const environment[] = {"HOME=/",  "DADRL_SCENARIO=x", "DADRL_ISA=avx2",
                                     "DADRL_=", "XDADRL_A=1",       nullptr};
  EXPECT_THAT(UnknownVariables(environment), ElementsAre("DADRL_SCENARIO", "DADRL_"));
}

TEST(Shown, IsOneShortLine) {
  EXPECT_EQ(Shown("plain"), "plain");
  EXPECT_EQ(Shown(std::string_view("a\n\0b\x7f", 5)), "a\\x0a\\x00b\\x7f");
  EXPECT_EQ(Shown(std::string(1000, 'x'), 3), "xxx...");
}

}  // namespace
}  // namespace dadrl
