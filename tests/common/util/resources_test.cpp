#include "common/util/resources.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <string>

#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

constexpr double kMiB = 1024.0 * 1024.0;

// A system made of files.
class ResourcesTest : public testing::Test {
 protected:
  void Put(const std::filesystem::path& file, const std::string& text) {
    std::filesystem::create_directories((folder_.path() / file).parent_path());
    std::ofstream(folder_.path() / file) << text;
  }
  SystemFolders System() const { return {folder_.path() / "proc", folder_.path() / "cgroup"}; }

  TemporaryFolder folder_;
  const int all_ = UsableCores(SystemFolders{"/nowhere", "/nowhere"});  // by affinity alone
};

TEST_F(ResourcesTest, WithoutLimitsThereIsWhatTheMachineHas) {
  Put("proc/self/cgroup", "0::/user.slice\n");
  Put("cgroup/user.slice/cpu.max", "max 100000\n");
  Put("cgroup/user.slice/memory.max", "max\n");
  Put("proc/meminfo", "MemTotal:  9 kB\nMemAvailable:   2048 kB\n");
  EXPECT_EQ(UsableCores(System()), all_);
  EXPECT_EQ(AvailableMemory(System()).bytes, 2 * kMiB);
  EXPECT_FALSE(AvailableMemory(System()).of_cgroup);
}

TEST_F(ResourcesTest, AQuotaOfOneAndAHalfCoresIsOne) {
  Put("proc/self/cgroup", "0::/job\n");
  Put("cgroup/job/cpu.max", "150000 100000\n");
  EXPECT_EQ(UsableCores(System()), 1);
  Put("cgroup/job/cpu.max", "10000 100000\n");
  EXPECT_EQ(UsableCores(System()), 1);
}

TEST_F(ResourcesTest, TheTightestOfTheGroupsAroundItCounts) {
  Put("proc/self/cgroup", "0::/batch/job\n");
  Put("proc/meminfo", "MemAvailable: 1000000 kB\n");
  Put("cgroup/batch/job/cpu.max", "max 100000\n");
  Put("cgroup/batch/cpu.max", "100000 100000\n");
  Put("cgroup/batch/job/memory.max", std::to_string(long{500} << 20));
  Put("cgroup/batch/memory.max", std::to_string(long{100} << 20));
  Put("cgroup/batch/memory.current", std::to_string(long{40} << 20));
  Put("cgroup/batch/memory.stat", "anon 5\ninactive_file " + std::to_string(long{10} << 20) + "\n");
  EXPECT_EQ(UsableCores(System()), 1);
  EXPECT_EQ(AvailableMemory(System()).bytes, 70 * kMiB);
  EXPECT_TRUE(AvailableMemory(System()).of_cgroup);
}

TEST_F(ResourcesTest, ReadsVersionOneAndAContainerThatSeesOnlyItsRoot) {
  Put("proc/self/cgroup", "7:memory:/docker/abc\n4:cpu,cpuacct:/docker/abc\n");
  Put("proc/meminfo", "MemAvailable: 1000000 kB\n");
  Put("cgroup/cpu/cpu.cfs_quota_us", "100000");
  Put("cgroup/cpu/cpu.cfs_period_us", "100000");
  Put("cgroup/memory/memory.limit_in_bytes", std::to_string(long{64} << 20));
  Put("cgroup/memory/memory.usage_in_bytes", std::to_string(long{16} << 20));
  EXPECT_EQ(UsableCores(System()), 1);
  EXPECT_EQ(AvailableMemory(System()).bytes, 48 * kMiB);
  Put("cgroup/cpu/cpu.cfs_quota_us", "-1");
  EXPECT_EQ(UsableCores(System()), all_);
}

TEST_F(ResourcesTest, NothingToReadIsNoLimit) {
  EXPECT_EQ(UsableCores(System()), all_);
  EXPECT_EQ(AvailableMemory(System()).bytes, 0.0);
}

TEST(UsableCores, IsWhatTheAffinityLeaves) {
  const pid_t pid = fork();  // the affinity of this process stays
  if (pid == 0) {
    cpu_set_t set;
    sched_getaffinity(0, sizeof set, &set);
    int first = 0;
    while (!CPU_ISSET(first, &set)) ++first;
    CPU_ZERO(&set);
    CPU_SET(first, &set);
    sched_setaffinity(0, sizeof set, &set);
    _exit(UsableCores());
  }
  int status = 0;
  waitpid(pid, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 1);
}

}  // namespace
}  // namespace dadrl
