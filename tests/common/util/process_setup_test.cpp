#include "common/util/process_setup.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <new>
#include <stdexcept>
#include <thread>

namespace dadrl {
namespace {

void SetLimit(int resource, rlim_t soft) {
  rlimit limit{};
  getrlimit(static_cast<__rlimit_resource>(resource), &limit);
  limit.rlim_cur = soft;
  setrlimit(static_cast<__rlimit_resource>(resource), &limit);
}

TEST(SetUpProcessDeathTest, TakesAllTheDescriptorsThatTheHostAllows) {
  EXPECT_EXIT(
      {
        SetLimit(RLIMIT_NOFILE, 40);
        SetUpProcess();
        rlimit limit{};
        getrlimit(RLIMIT_NOFILE, &limit);
        _exit(limit.rlim_cur == limit.rlim_max ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

TEST(SetUpProcessDeathTest, AFileBeyondItsLimitIsAnErrorOfTheWrite) {
  EXPECT_EXIT(
      {
        SetUpProcess();
        SetLimit(RLIMIT_FSIZE, 0);
        std::FILE* const file = std::tmpfile();
        _exit(write(fileno(file), "x", 1) < 0 && errno == EFBIG ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

TEST(SetUpProcessDeathTest, AThreadWithoutMemoryEndsTheProcessWithTheLimitAndTheRemedy) {
  EXPECT_EXIT(
      {
        SetUpProcess();
        SetLimit(RLIMIT_AS, rlim_t{1} << 40);
        std::thread([] { throw std::bad_alloc(); }).join();
      },
      testing::ExitedWithCode(1), "out of memory: this process may use 1073741824 KiB; raise that");
  EXPECT_EXIT(
      {
        SetUpProcess();
        std::thread([] { throw std::runtime_error("what it was"); }).join();
      },
      testing::ExitedWithCode(1), "unexpected: what it was");
}

}  // namespace
}  // namespace dadrl
