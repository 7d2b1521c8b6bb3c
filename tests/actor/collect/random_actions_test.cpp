#include "actor/collect/random_actions.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dadrl {
namespace {

TEST(RandomActions, HoldsEachActionForUpToASecond) {
  Random random(7);
  RandomActions actions(0.1);
  int longest = 0;
  int held = 0;
  int draws = 0;
  Action last{2.0f, 2.0f};
  for (int i = 0; i < 20000; ++i) {
    const Action action = actions.Next(random);
    held = action == last ? held + 1 : 1;
    draws += held == 1 ? 1 : 0;
    longest = std::max(longest, held);
    last = action;
  }
  EXPECT_EQ(longest, 10);
  EXPECT_NEAR(20000.0 / draws, 5.0, 0.3) << "half a second on average";
}

TEST(RandomActions, HoldsALongDecisionOnce) {
  Random random(7);
  RandomActions actions(2.0);
  const Action first = actions.Next(random);
  EXPECT_NE(actions.Next(random), first);
}

TEST(RandomActions, CoversTheOpenSquareEvenly) {
  Random random(3);
  RandomActions actions(1.0);
  std::array<double, 2> sum{};
  std::array<double, 2> squares{};
  constexpr int kDraws = 20000;
  for (int i = 0; i < kDraws; ++i) {
    const Action action = actions.Next(random);
    for (size_t k = 0; k < 2; ++k) {
      ASSERT_LT(std::abs(action[k]), 1.0f);
      sum[k] += action[k];
      squares[k] += action[k] * action[k];
    }
  }
  for (size_t k = 0; k < 2; ++k) {
    EXPECT_NEAR(sum[k] / kDraws, 0.0, 0.02);
    EXPECT_NEAR(squares[k] / kDraws, 1.0 / 3.0, 0.02);
  }
}

TEST(RandomActions, DrawsAfreshForAnEpisode) {
  Random random(1);
  RandomActions actions(0.01);
  const Action first = actions.Next(random);
  actions.Restart();
  EXPECT_NE(actions.Next(random), first);
}

}  // namespace
}  // namespace dadrl
