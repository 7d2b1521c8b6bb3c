#include "replay/service/request_queue.h"

#include <gtest/gtest.h>

namespace dadrl {
namespace {

using Verdict = RequestQueue::Verdict;

class RequestQueueTest : public testing::Test {
 protected:
  // As the server does it.
  Verdict Arrive(uint64_t learner, uint64_t number, uint64_t oldest_open = 0) {
    const Verdict verdict = queue_.OnArrival({learner, number}, oldest_open);
    if (verdict == Verdict::kNew) queue_.Push({.id = {learner, number}, .shape = {.count = 16}});
    return verdict;
  }
  std::vector<uint64_t> Waiting() {
    std::vector<uint64_t> numbers;
    for (const auto& request : queue_.pending()) numbers.push_back(request.id.number);
    return numbers;
  }

  using Numbers = std::vector<uint64_t>;
  RequestQueue queue_;
};

TEST_F(RequestQueueTest, KeepsTheOrderOfArrivalAndOneCopyOfEach) {
  EXPECT_EQ(Arrive(7, 1), Verdict::kNew);
  EXPECT_EQ(Arrive(7, 2), Verdict::kNew);
  queue_.front().notified = true;
  EXPECT_EQ(Arrive(7, 1), Verdict::kKnown);
  EXPECT_FALSE(queue_.front().notified) << "who asks again hears again";
  EXPECT_EQ(Waiting(), Numbers({1, 2}));
}

TEST_F(RequestQueueTest, KeepsNothingThatTheLearnerHasGivenUp) {
  for (uint64_t number = 1; number <= 5; ++number) Arrive(7, number);
  EXPECT_EQ(Arrive(7, 9, 4), Verdict::kNew);
  EXPECT_EQ(Waiting(), Numbers({4, 5, 9}));
  EXPECT_EQ(Arrive(7, 3, 1), Verdict::kGivenUp) << "a late copy";
  EXPECT_EQ(Waiting(), Numbers({4, 5, 9}));
}

TEST_F(RequestQueueTest, OfAFloodTheNewestStay) {
  constexpr uint64_t kFlood = 10 * RequestQueue::kMaxPending;
  for (uint64_t number = 1; number <= kFlood; ++number) EXPECT_EQ(Arrive(7, number), Verdict::kNew);
  EXPECT_EQ(queue_.size(), RequestQueue::kMaxPending);
  EXPECT_EQ(queue_.front().id.number, kFlood - RequestQueue::kMaxPending + 1);
}

TEST_F(RequestQueueTest, ALaterLearnerTakesOverAndTheEarlierOneIsTold) {
  Arrive(7, 100, 90);
  EXPECT_EQ(Arrive(8, 1), Verdict::kNew) << "it counts from 1 again";
  EXPECT_EQ(Waiting(), Numbers({1}));
  EXPECT_EQ(queue_.learner(), 8u);
  EXPECT_EQ(Arrive(7, 101), Verdict::kSuperseded);
  EXPECT_EQ(Waiting(), Numbers({1}));
}

TEST_F(RequestQueueTest, DoesNotBelieveALearnerThatGivesUpTheFuture) {
  EXPECT_EQ(Arrive(7, 1, UINT64_MAX), Verdict::kNew);
  EXPECT_EQ(Arrive(7, 2, 2), Verdict::kNew);
  EXPECT_EQ(Waiting(), Numbers({2}));
}

}  // namespace
}  // namespace dadrl
