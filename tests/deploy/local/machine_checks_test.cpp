#include "deploy/local/machine_checks.h"

#include <gmock/gmock.h>

namespace dadrl {
namespace {

using ::testing::HasSubstr;

constexpr double kGiB = 1024.0 * 1024.0 * 1024.0;

TEST(MachineChecks, SmallReceiveBuffersComeWithTheCommandThatMendsThem) {
  EXPECT_EQ(CheckReceiveBuffer(4 << 20, 4 << 20).state, CheckState::kGood);
  const MachineCheck check = CheckReceiveBuffer(4 << 20, 212992);
  EXPECT_EQ(check.state, CheckState::kWarning);
  EXPECT_EQ(check.remedy, "sysctl -w net.core.rmem_max=4194304");
}

TEST(MachineChecks, LittleDiskWarnsAndNoDiskBreaks) {
  EXPECT_EQ(CheckDisk(".", 20 * kGiB, 9 * kGiB).state, CheckState::kGood);
  EXPECT_EQ(CheckDisk(".", 5 * kGiB, 9 * kGiB).state, CheckState::kWarning);
  EXPECT_EQ(CheckDisk(".", 0.5 * kGiB, 9 * kGiB).state, CheckState::kBroken);
  EXPECT_THAT(CheckDisk(".", 5 * kGiB, 9 * kGiB).remedy, HasSubstr("free 4.0 GiB"));
}

TEST(MachineChecks, MemoryAndCoresOnlyWarn) {
  EXPECT_EQ(CheckMemory({8 * kGiB}, 4 * kGiB).state, CheckState::kGood);
  EXPECT_EQ(CheckMemory({2 * kGiB}, 4 * kGiB).state, CheckState::kWarning);
  EXPECT_THAT(CheckMemory({2 * kGiB, true}, 4 * kGiB).detail, HasSubstr("2.0 GiB available to this cgroup"));
  EXPECT_EQ(CheckCores(2, 2).state, CheckState::kGood);
  EXPECT_EQ(CheckCores(2, 9).state, CheckState::kWarning);
}

TEST(MachineChecks, WhateverIsNotGoodSaysHowToMendIt) {
  const auto checks = CheckMachine(Config{});
  EXPECT_FALSE(checks.empty());
  for (const MachineCheck& check : checks) {
    EXPECT_FALSE(check.detail.empty()) << check.name;
    EXPECT_EQ(check.remedy.empty(), check.state == CheckState::kGood) << check.name;
  }
}

}  // namespace
}  // namespace dadrl
