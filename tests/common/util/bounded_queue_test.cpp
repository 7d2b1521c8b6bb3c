#include "common/util/bounded_queue.h"

#include <gtest/gtest.h>

#include <memory>
#include <thread>

namespace dadrl {
namespace {

constexpr Duration kLong = std::chrono::seconds(30);

TEST(BoundedQueue, RefusesWhenFullAndKeepsTheItem) {
  BoundedQueue<std::unique_ptr<int>> queue(1);
  auto first = std::make_unique<int>(1);
  auto second = std::make_unique<int>(2);
  EXPECT_TRUE(queue.TryPush(first));
  EXPECT_FALSE(queue.TryPush(second));
  ASSERT_NE(second, nullptr);
  EXPECT_EQ(**queue.Pop(Duration::zero()), 1);
  EXPECT_TRUE(queue.TryPush(second));
}

TEST(BoundedQueue, PassesEverythingInOrderBetweenThreads) {
  BoundedQueue<int> queue(3);
  std::thread producer([&] {
    for (int i = 0; i < 1000; ++i) ASSERT_TRUE(queue.Push(i, kLong));
    queue.Close();
  });
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(queue.Pop(kLong), i);
  EXPECT_EQ(queue.Pop(kLong), std::nullopt);
  producer.join();
}

TEST(BoundedQueue, CloseWakesAWaitingConsumer) {
  BoundedQueue<int> queue(1);
  std::thread consumer([&] { EXPECT_EQ(queue.Pop(kLong), std::nullopt); });
  queue.Close();
  consumer.join();
  EXPECT_FALSE(queue.Push(1, kLong));
}

TEST(BoundedQueue, TimesOut) {
  BoundedQueue<int> queue(1);
  EXPECT_EQ(queue.Pop(Duration::zero()), std::nullopt);
  EXPECT_TRUE(queue.Push(1, Duration::zero()));
  EXPECT_FALSE(queue.Push(2, std::chrono::milliseconds(1)));
}

}  // namespace
}  // namespace dadrl
