#include "learner/request_book.h"

#include <gtest/gtest.h>

#include <map>

namespace dadrl {
namespace {

using namespace std::chrono_literals;

constexpr TimePoint kStart{100s};
constexpr Duration kTimeout = 2s;

TEST(RequestBook, NeverHasMoreOpenAndReadyThanCredits) {
  RequestBook book(1, 3, kTimeout);
  EXPECT_EQ(book.Due(kStart, 0).size(), 3u);
  EXPECT_TRUE(book.Due(kStart, 0).empty());
  ASSERT_TRUE(book.OnReply({0, 1}, 100));
  EXPECT_TRUE(book.Due(kStart, 1).empty());   // the batch waits for the trainer and keeps its credit
  EXPECT_EQ(book.Due(kStart, 0).size(), 1u);  // taken
}

TEST(RequestBook, TellsAShardWhichRequestsAreGivenUp) {
  RequestBook book(2, 1, kTimeout);
  const RequestBook::Request first = book.Due(kStart, 0)[0];
  EXPECT_EQ(book.oldest_open(first.shard), first.number);
  const RequestBook::Request second = book.Due(kStart + kTimeout, 0)[0];
  ASSERT_NE(second.shard, first.shard);
  EXPECT_GT(book.oldest_open(first.shard), first.number) << "the shard was silent";
  EXPECT_EQ(book.oldest_open(second.shard), second.number);
}

TEST(RequestBook, AcceptsEachReplyOnceAndOnlyWhatWasAsked) {
  RequestBook book(2, 2, kTimeout);
  const RequestBook::Request first = book.Due(kStart, 0)[0];
  EXPECT_FALSE(book.OnReply({first.shard, 77}, 1));
  EXPECT_FALSE(book.OnReply({1 - first.shard, first.number}, 1));
  EXPECT_TRUE(book.OnReply(first, 1));
  EXPECT_FALSE(book.OnReply(first, 1));
}

TEST(RequestBook, RepeatsAnUnansweredRequestUnderItsNumber) {
  RequestBook book(1, 1, kTimeout);
  const RequestBook::Request asked = book.Due(kStart, 0)[0];
  EXPECT_TRUE(book.Due(kStart + kTimeout - 1ns, 0).empty());
  EXPECT_EQ(book.next_due(kStart), kStart + kTimeout);
  const auto due = book.Due(kStart + kTimeout, 0);
  ASSERT_EQ(due.size(), 1u);
  EXPECT_EQ(due[0].number, asked.number);
  EXPECT_EQ(book.repeated(), 1u);
  EXPECT_TRUE(book.Due(kStart + kTimeout, 0).empty());
}

TEST(RequestBook, RepeatsAllWhenAShardReappears) {
  RequestBook book(1, 2, kTimeout);
  book.Due(kStart, 0);
  ASSERT_TRUE(book.OnWithheld({0, 1}, 5, kStart));
  book.RepeatAll();
  EXPECT_FALSE(book.all_withheld());
  EXPECT_EQ(book.next_due(kStart), kStart);
  EXPECT_EQ(book.Due(kStart, 0).size(), 2u);
}

TEST(RequestBook, WithheldRequestStaysOpenAndKeepsItsCredit) {
  RequestBook book(1, 1, kTimeout);
  const RequestBook::Request asked = book.Due(kStart, 0)[0];
  EXPECT_FALSE(book.all_withheld());
  ASSERT_TRUE(book.OnWithheld(asked, 5, kStart + 1s));
  EXPECT_TRUE(book.all_withheld());
  EXPECT_TRUE(book.Due(kStart + 1s + kTimeout - 1ns, 0).empty());
  EXPECT_TRUE(book.OnReply(asked, 100));
  EXPECT_FALSE(book.all_withheld());
}

TEST(RequestBook, AShardThatWithholdsDoesNotHoldUpTheOthers) {
  RequestBook book(2, 2, kTimeout);
  TimePoint now = kStart;
  int served = 0;
  for (int round = 0; round < 100; ++round, now += 1ms) {
    for (const auto& request : std::vector(book.Due(now, 0))) {
      if (request.shard == 0) {
        ASSERT_TRUE(book.OnWithheld(request, 0, now));  // no actor has written to it yet
      } else {
        ASSERT_TRUE(book.OnReply(request, 1000));
        ++served;
      }
    }
    ASSERT_FALSE(book.idle());
  }
  EXPECT_GE(served, 98);
}

TEST(RequestBook, AsksAWithholdingShardNoMoreUntilItServes) {
  RequestBook book(2, 3, kTimeout);
  std::vector<RequestBook::Request> withheld;
  TimePoint now = kStart;
  for (int round = 0; round < 20; ++round, now += 1ms) {
    for (const auto& request : std::vector(book.Due(now, 0))) {
      withheld.push_back(request);
      ASSERT_TRUE(book.OnWithheld(request, 10, now));
    }
  }
  EXPECT_TRUE(book.all_withheld());
  EXPECT_LE(withheld.size(), 6u) << "credits x shards";
  const size_t before = withheld.size();
  EXPECT_TRUE(book.Due(now, 0).empty());
  for (const auto& request : withheld) ASSERT_TRUE(book.OnReply(request, 10));
  EXPECT_EQ(book.Due(now, static_cast<int>(before)).size(), 0u) << "what is ready holds credits";
  EXPECT_EQ(book.Due(now, 0).size(), 3u);
}

TEST(RequestBook, SharesFollowTheFramesThatShardsHold) {
  RequestBook book(3, 1, kTimeout);
  const std::map<uint32_t, uint64_t> held = {{0, 1000}, {1, 3000}, {2, 0}};
  std::map<uint32_t, int> asked;
  for (int i = 0; i < 4000; ++i) {
    const RequestBook::Request request = book.Due(kStart, 0)[0];
    ++asked[request.shard];
    ASSERT_TRUE(book.OnReply(request, held.at(request.shard)));
  }
  EXPECT_NEAR(asked[0], 1000, 10);
  EXPECT_NEAR(asked[1], 3000, 10);
  EXPECT_GE(asked[2], 1);  // was asked once, before it said that it is empty
  EXPECT_LE(asked[2], 10);
}

TEST(RequestBook, SilentShardLosesItsCreditsToTheOthersForAWhile) {
  RequestBook book(2, 4, kTimeout);
  TimePoint now = kStart;
  for (const auto& request : std::vector(book.Due(now, 0))) {
    if (request.shard == 0) book.OnReply(request, 100);  // shard 1 is dead
  }
  now += kTimeout;
  int to_living = 0;
  for (const auto& request : book.Due(now, 0)) to_living += request.shard == 0;
  EXPECT_EQ(to_living, 4);
  EXPECT_EQ(book.given_up(), 2u);
  // It is tried again later, so that it is found when it lives.
  for (uint64_t number = 1; number < 20; ++number) book.OnReply({0, number}, 100);
  now += 2 * kTimeout;
  int to_silent = 0;
  for (const auto& request : book.Due(now, 0)) to_silent += request.shard == 1;
  EXPECT_GE(to_silent, 1);
}

TEST(RequestBook, AsksOnWhenEveryShardIsSilent) {
  RequestBook book(2, 2, kTimeout);
  book.Due(kStart, 0);
  EXPECT_EQ(book.Due(kStart + kTimeout, 0).size(), 2u);
}

TEST(RequestBook, HoldsOffNewRequestsOnly) {
  RequestBook book(1, 2, kTimeout);
  book.Due(kStart, 0);
  ASSERT_TRUE(book.OnReply({0, 1}, 1));
  book.HoldOff(kStart + 100ms);
  EXPECT_TRUE(book.Due(kStart, 0).empty());
  EXPECT_EQ(book.next_due(kStart), kStart + 100ms);
  EXPECT_EQ(book.Due(kStart + 100ms, 0).size(), 1u);
}

}  // namespace
}  // namespace dadrl
