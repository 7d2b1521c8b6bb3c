#include "common/nn/thread_team.h"

#include <gtest/gtest.h>

#include <cfloat>
#include <vector>

namespace dadrl::nn {
namespace {

TEST(ThreadTeamTest, RunsEveryMemberOnceARun) {
  for (const int threads : {1, 2, 5}) {
    ThreadTeam team(threads);
    EXPECT_EQ(team.size(), threads);
    std::vector<int> runs(static_cast<size_t>(threads));
    auto work = [&](int member) { ++runs[static_cast<size_t>(member)]; };
    for (int i = 0; i < 200; ++i) team.Run(work);
    EXPECT_EQ(runs, std::vector<int>(static_cast<size_t>(threads), 200));
  }
}

TEST(ThreadTeamTest, BarrierMakesEarlierWritesVisible) {
  constexpr int kThreads = 4;
  ThreadTeam team(kThreads);
  std::vector<int> values(kThreads);
  std::vector<int> sums(kThreads);
  auto work = [&](int member) {
    for (int round = 1; round <= 100; ++round) {
      values[static_cast<size_t>(member)] = round;
      team.Barrier();
      sums[static_cast<size_t>(member)] = 0;
      for (const int value : values) sums[static_cast<size_t>(member)] += value;
      team.Barrier();
      if (sums[static_cast<size_t>(member)] != kThreads * round) ADD_FAILURE() << "round " << round;
    }
  };
  team.Run(work);
}

TEST(ThreadTeamTest, FlushesDenormalsOnEveryMemberAndRestoresTheCaller) {
  ThreadTeam team(3);
  std::vector<float> products(3, 1.0f);
  volatile float tiny = FLT_MIN;
  auto work = [&](int member) { products[static_cast<size_t>(member)] = tiny * 0.5f; };
  team.Run(work);
#if defined(__x86_64__)
  EXPECT_EQ(products, std::vector<float>(3, 0.0f));
#endif
  EXPECT_NE(tiny * 0.5f, 0.0f);
}

}  // namespace
}  // namespace dadrl::nn
