#include "replay/service/lease_table.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <set>

namespace dadrl {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr uint32_t kReserved = 4;
constexpr uint64_t kLeast = 1000;

class LeaseTableTest : public testing::Test {
 protected:
  // As of a replay that has served for a while.
  LeaseTableTest() {
    Restart();
    now_ += kLeaseTerm;
  }
  void Restart() { table_ = std::make_unique<LeaseTable>(kReserved, LeaseTable::kFirstAny, now_); }
  // An actor that has no number yet.
  LeaseTable::Answer Want(uint64_t token, std::optional<uint32_t> number, uint64_t start = 1) {
    return table_->Ask({.token = {token, token},
                        .start = start,
                        .number = number,
                        .who = fmt::format("host-{}, pid {}", token, start)},
                       now_, kLeast);
  }
  // One that shows what it has.
  LeaseTable::Answer Show(uint64_t token, uint32_t number, uint64_t incarnation, uint64_t start = 1) {
    return table_->Ask(
        {.token = {token, token}, .start = start, .number = number, .incarnation = incarnation, .who = "x"},
        now_, kLeast);
  }

  TimePoint now_{100s};
  std::unique_ptr<LeaseTable> table_;
};

TEST_F(LeaseTableTest, OfTwoThatWantTheSameNumberOneHasIt) {
  const auto first = Want(1, 7);
  EXPECT_EQ(first.verdict, LeaseVerdict::kGranted);
  EXPECT_EQ(first.number, 7u);
  EXPECT_GE(first.incarnation, kLeast);
  now_ += 3s;
  const auto second = Want(2, 7);
  EXPECT_EQ(second.verdict, LeaseVerdict::kHeld);
  EXPECT_THAT(second.reason, HasSubstr("actor number 7 is held by host-1, pid 1, for 3 s now"));
  EXPECT_EQ(Want(1, 7).incarnation, first.incarnation) << "its answer was lost";
}

TEST_F(LeaseTableTest, ANumberIsFreeWhenItsHolderLeavesOrFallsSilentAndComesWithAnotherIncarnation) {
  const auto first = Want(1, 7);
  now_ += kLeaseTerm - 1ms;
  EXPECT_EQ(Want(2, 7).verdict, LeaseVerdict::kHeld);
  now_ += 1ms;
  const auto second = Want(2, 7);
  EXPECT_EQ(second.verdict, LeaseVerdict::kGranted);
  EXPECT_GT(second.incarnation, first.incarnation);
  table_->Ask({.token = {2, 2}, .start = 1, .number = 7, .incarnation = second.incarnation, .leaving = true},
              now_, kLeast);
  const auto third = Want(3, 7);
  EXPECT_EQ(third.verdict, LeaseVerdict::kGranted);
  EXPECT_GT(third.incarnation, second.incarnation);
}

TEST_F(LeaseTableTest, AHolderThatSpeaksKeepsItsNumber) {
  const auto held = Want(1, 7);
  for (int i = 0; i < 20; ++i) {
    now_ += kLeaseRenewal;
    EXPECT_EQ(Show(1, 7, held.incarnation).verdict, LeaseVerdict::kGranted);
    EXPECT_EQ(Want(2, 7).verdict, LeaseVerdict::kHeld);
  }
}

TEST_F(LeaseTableTest, WhoComesBackLateIsToldThatAnotherHasItsNumber) {
  const auto old = Want(1, 7);
  now_ += kLeaseTerm;
  const auto held = Want(2, 7);
  now_ += 5s;
  const auto back = Show(1, 7, old.incarnation);
  EXPECT_EQ(back.verdict, LeaseVerdict::kLost);
  EXPECT_THAT(back.reason, HasSubstr("actor number 7 went to another actor (host-2, pid 1) 5 s ago"));
  EXPECT_EQ(Show(2, 7, held.incarnation).verdict, LeaseVerdict::kGranted);
  now_ += 10 * kLeaseTerm;
  EXPECT_EQ(Show(1, 7, old.incarnation).verdict, LeaseVerdict::kLost)
      << "the replay has chunks of a later incarnation, though nobody has the number now";
}

TEST_F(LeaseTableTest, WhoComesBackLateAndFindsItsNumberFreeGoesOn) {
  const auto old = Want(1, 7);
  now_ += 100 * kLeaseTerm;
  EXPECT_EQ(Show(1, 7, old.incarnation).verdict, LeaseVerdict::kGranted);
  EXPECT_EQ(Want(2, 7).verdict, LeaseVerdict::kHeld);
}

TEST_F(LeaseTableTest, AnActorThatWasStartedAgainTakesOverAtOnceAndTheProcessBeforeItIsTold) {
  const auto old = Want(1, 7, 10);
  const auto fresh = Want(1, 7, 11);
  EXPECT_EQ(fresh.verdict, LeaseVerdict::kGranted);
  EXPECT_GT(fresh.incarnation, old.incarnation);
  EXPECT_EQ(Show(1, 7, old.incarnation, 10).verdict, LeaseVerdict::kLost);
  EXPECT_EQ(Show(1, 7, fresh.incarnation, 11).verdict, LeaseVerdict::kGranted);
}

TEST_F(LeaseTableTest, WhoWantsAnyGetsOneThatNobodyHad) {
  std::set<uint32_t> numbers;
  for (uint64_t token = 1; token <= 100; ++token) {
    const auto answer = Want(token, std::nullopt);
    EXPECT_EQ(answer.verdict, LeaseVerdict::kGranted);
    EXPECT_GE(answer.number, LeaseTable::kFirstAny);
    EXPECT_TRUE(numbers.insert(answer.number).second);
  }
  EXPECT_EQ(Want(5, std::nullopt, 2).number, Want(5, std::nullopt, 3).number) << "its own again";
  now_ += LeaseTable::kReuseAfter;
  EXPECT_TRUE(numbers.contains(Want(1000, std::nullopt).number)) << "those long silent are given out again";
}

TEST_F(LeaseTableTest, AfterARestartHoldersKeepTheirNumbersAndOthersWaitUntilTheyHaveSpoken) {
  const auto held = Want(1, 7);
  const auto own = Want(2, 0);
  now_ += 1s;
  Restart();
  EXPECT_EQ(Want(3, 7).verdict, LeaseVerdict::kWait);
  EXPECT_EQ(Want(4, std::nullopt).verdict, LeaseVerdict::kWait);
  EXPECT_EQ(Want(2, 0, 2).verdict, LeaseVerdict::kGranted) << "the run's own numbers are nobody else's";
  EXPECT_EQ(Show(1, 7, held.incarnation).incarnation, held.incarnation);
  EXPECT_EQ(Show(2, 0, own.incarnation).verdict, LeaseVerdict::kLost);
  EXPECT_EQ(Want(3, 7).verdict, LeaseVerdict::kHeld);
  now_ += kLeaseTerm;
  EXPECT_EQ(Want(4, std::nullopt).verdict, LeaseVerdict::kGranted);
}

TEST_F(LeaseTableTest, OfTwoThatShowTheSameNumberTheLaterHolderHasItInEitherOrder) {
  for (const bool later_first : {true, false}) {
    Restart();
    Show(1, 7, later_first ? 200 : 100);
    Show(2, 7, later_first ? 100 : 200);
    EXPECT_EQ(Show(1, 7, later_first ? 200 : 100).verdict,
              later_first ? LeaseVerdict::kGranted : LeaseVerdict::kLost);
    EXPECT_EQ(Show(2, 7, later_first ? 100 : 200).verdict,
              later_first ? LeaseVerdict::kLost : LeaseVerdict::kGranted);
  }
}

TEST_F(LeaseTableTest, WhatItRemembersIsBounded) {
  EXPECT_EQ(Want(1, LeaseTable::kMaxNumber + 1).verdict, LeaseVerdict::kHeld);
  for (uint32_t number = 0; number < LeaseTable::kMaxLeases; ++number) Want(number + 1, number);
  const auto one_more = Want(LeaseTable::kMaxLeases + 1, LeaseTable::kMaxLeases);
  EXPECT_EQ(one_more.verdict, LeaseVerdict::kHeld);
  EXPECT_THAT(one_more.reason, HasSubstr("all 65536 actor numbers are taken"));
}

}  // namespace
}  // namespace dadrl
