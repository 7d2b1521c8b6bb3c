#include "common/util/background_thread.h"

#include <gtest/gtest.h>

#include <future>
#include <optional>
#include <thread>
#include <utility>

#include "common/util/bounded_queue.h"

namespace dadrl {
namespace {

constexpr Duration kSoon = std::chrono::seconds(10);

// Rounds of a thread as they happen: whether each was the last.
class Rounds {
 public:
  BackgroundThread::Work Work(Duration rest) {
    return [this, rest](bool last) {
      EXPECT_TRUE(rounds_.Push(last, kSoon));
      return rest;
    };
  }
  std::optional<bool> Next() { return rounds_.Pop(kSoon); }
  size_t waiting() const { return rounds_.size(); }

 private:
  BoundedQueue<bool> rounds_{2};
};

TEST(BackgroundThread, WorksAtOnceThenAfterEachRest) {
  Rounds rounds;
  std::optional<BackgroundThread> thread(std::in_place, rounds.Work(std::chrono::microseconds(1)));
  for (int i = 0; i < 5; ++i) EXPECT_EQ(rounds.Next(), false);
  std::thread reader([&] {
    while (rounds.Next() == false) {
    }
  });
  thread.reset();
  reader.join();
}

TEST(BackgroundThread, RestsUntilWokenAndWorksOnceMoreAtTheEnd) {
  for (const Duration rest : {BackgroundThread::kUntilWoken, Duration(std::chrono::hours(1))}) {
    Rounds rounds;
    {
      BackgroundThread thread(rounds.Work(rest));
      EXPECT_EQ(rounds.Next(), false);
      thread.Wake();
      EXPECT_EQ(rounds.Next(), false);
      EXPECT_EQ(rounds.waiting(), 0u);
    }
    EXPECT_EQ(rounds.Next(), true);
    EXPECT_EQ(rounds.waiting(), 0u);
  }
}

TEST(BackgroundThread, WorksAgainWhenWokenDuringARound) {
  Rounds rounds;
  std::promise<void> began;
  std::promise<void> go_on;
  bool first = true;
  const auto count = rounds.Work(BackgroundThread::kUntilWoken);
  BackgroundThread thread([&](bool last) {
    if (std::exchange(first, false)) {
      began.set_value();
      go_on.get_future().wait();
    }
    return count(last);
  });
  began.get_future().wait();
  thread.Wake();
  go_on.set_value();
  EXPECT_EQ(rounds.Next(), false);
  EXPECT_EQ(rounds.Next(), false);
}

}  // namespace
}  // namespace dadrl
