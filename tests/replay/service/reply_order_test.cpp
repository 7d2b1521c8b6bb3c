#include "replay/service/reply_order.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace dadrl {
namespace {

TEST(ReplyOrder, EachWaitsUntilAllBeforeItHaveLeft) {
  constexpr uint64_t kReplies = 200;
  constexpr uint64_t kThreads = 4;
  ReplyOrder order;
  for (uint64_t number = 0; number < kReplies; ++number) order.TakePlace({1, number});
  std::vector<uint64_t> sent;  // only in turn, so without a lock
  std::vector<std::thread> threads;
  for (uint64_t thread = 0; thread < kThreads; ++thread) {
    threads.emplace_back([&, thread] {
      for (uint64_t number = thread; number < kReplies; number += kThreads) {
        order.WaitForTurn({1, number});
        sent.push_back(number);
        order.Leave();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  ASSERT_EQ(sent.size(), kReplies);
  for (uint64_t number = 0; number < kReplies; ++number) EXPECT_EQ(sent[number], number);
}

TEST(ReplyOrder, HoldsARequestOfOneLearnerUntilItsPlaceIsLeft) {
  ReplyOrder order;
  order.TakePlace({7, 1});
  order.TakePlace({7, 2});
  EXPECT_TRUE(order.Holds({7, 2}));
  EXPECT_FALSE(order.Holds({8, 2})) << "another learner counts its own requests";
  order.WaitForTurn({7, 1});
  order.Leave();
  EXPECT_FALSE(order.Holds({7, 1}));
  EXPECT_TRUE(order.Holds({7, 2}));
}

}  // namespace
}  // namespace dadrl
