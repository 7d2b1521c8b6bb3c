// Actors that ask for numbers, and the replay's server that gives them out, on a clock of the test's.
#include "replay/service/lease_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "actor/experience/lease_holder.h"
#include "common/port/memory_transport.h"

namespace dadrl {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr uint64_t kSchema = 0xabc;

class LeaseServerTest : public testing::Test {
 protected:
  LeaseServerTest() {
    Open();
    Pass(kLeaseTerm);
  }
  // The replay serves, and hears nobody.
  void Pass(Duration duration) {
    for (const TimePoint end = clock_.Now() + duration; clock_.Now() < end; clock_.Advance(500ms)) {
      server_->Serve();
    }
  }
  void Open() { server_ = LeaseServer::Create(transport_, config_, kSchema, 0, clock_).value(); }
  std::unique_ptr<LeaseHolder> Actor(uint64_t token, std::optional<uint32_t> number,
                                     uint64_t schema = kSchema) {
    return LeaseHolder::Create(
               transport_, {.token = {token, token}, .start = 1, .number = number, .schema = schema}, clock_)
        .value();
  }
  // Time passes while an actor waits, and the replay answers.
  Result<LeaseHolder::Lease> Acquire(LeaseHolder& actor) {
    return actor.Acquire([this] {
      server_->Serve();
      clock_.Advance(250ms);
      return true;
    });
  }
  // The actor lives for a while.
  bool Live(LeaseHolder& actor, Duration duration) {
    bool holds = true;
    for (const TimePoint end = clock_.Now() + duration; holds && clock_.Now() < end;) {
      holds = actor.Step(clock_.Now());
      server_->Serve();
      clock_.Advance(10ms);
    }
    return holds;
  }

  Config config_;
  ManualClock clock_;
  const MemoryTransport transport_{clock_};
  std::unique_ptr<LeaseServer> server_;
};

TEST_F(LeaseServerTest, OfTwoThatWantANumberOneHasItAndTheOtherIsToldWhoUntilThatOneLeaves) {
  auto first = Actor(1, 7);
  const auto lease = Acquire(*first);
  ASSERT_TRUE(lease) << lease.error().message;
  EXPECT_EQ(lease->number, 7u);
  EXPECT_GE(lease->incarnation, static_cast<uint64_t>(kLeaseTerm.count())) << "no less than the wall time";
  auto second = Actor(2, 7);
  const auto refused = second->Acquire([&] {
    Live(*first, 250ms);
    return true;
  });
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kExhausted);
  EXPECT_THAT(refused.error().message, HasSubstr("actor number 7 is held by "));
  EXPECT_THAT(refused.error().message, HasSubstr(fmt::format("pid {}", getpid())));
  first.reset();
  const auto given = Acquire(*second);
  ASSERT_TRUE(given) << given.error().message;
  EXPECT_GT(given->incarnation, lease->incarnation);
}

TEST_F(LeaseServerTest, AHolderThatWasAwayTooLongIsToldWhoHasItsNumber) {
  auto old = Actor(1, 7);
  ASSERT_TRUE(Acquire(*old));
  Pass(kLeaseTerm);
  auto fresh = Actor(2, 7);
  ASSERT_TRUE(Acquire(*fresh));
  EXPECT_FALSE(Live(*old, 2 * kLeaseRenewal));
  EXPECT_THAT(old->lost(), HasSubstr("actor number 7 went to another actor"));
  EXPECT_TRUE(Live(*fresh, 10s));
}

TEST_F(LeaseServerTest, AReplayThatGotNoCoreForAWhileTakesNumbersFromNobody) {
  auto holder = Actor(1, 7);
  ASSERT_TRUE(Acquire(*holder));
  server_->Serve();
  clock_.Advance(2 * kLeaseTerm);
  // Who asks for the number is heard before its holder is.
  auto other = Actor(2, 7);
  bool asked = false;
  EXPECT_FALSE(other->Acquire([&] { return !std::exchange(asked, true) || Live(*holder, 250ms); }));
  EXPECT_EQ(holder->lost(), "");
}

TEST_F(LeaseServerTest, AReplayThatWasStartedAgainHearsWhoHasWhichNumber) {
  auto holder = Actor(1, 7);
  ASSERT_TRUE(Acquire(*holder));
  server_.reset();
  Open();
  EXPECT_TRUE(holder->connected());
  auto other = Actor(2, 7);
  const auto refused = other->Acquire([&] {
    Live(*holder, 250ms);
    return true;
  });
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kExhausted);
  EXPECT_TRUE(Live(*holder, 10s));
}

TEST_F(LeaseServerTest, OtherObservationsAreTurnedAwayWithBothSidesNamed) {
  auto actor = Actor(1, 7, 0xdef);
  const auto refused = Acquire(*actor);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(refused.error().message, HasSubstr("schema 0xdef, the replay holds 0xabc"));
}

TEST_F(LeaseServerTest, AnotherVersionIsTurnedAwayWithBothSidesNamed) {
  const auto answers = Reader<dadrl_idl_LeaseAnswer>::Create(transport_, LeaseAnswerTopic({1, 1})).value();
  const auto requests = Writer<dadrl_idl_LeaseRequest>::Create(transport_, kLeaseRequestTopic).value();
  dadrl_idl_LeaseRequest request{};
  request.token_high = request.token_low = 1;
  request.protocol = kProtocolVersion + 1;
  request.schema = kSchema;
  std::string reason;
  uint32_t version = 0;
  ASSERT_TRUE(requests->Write(request));
  server_->Serve();
  answers->Take(1, [&](const dadrl_idl_LeaseAnswer& answer) {
    version = answer.protocol;
    reason = answer.reason;
  });
  EXPECT_EQ(version, kProtocolVersion);
  EXPECT_THAT(reason, HasSubstr(fmt::format("the actor speaks version {} of the protocol, the replay {}",
                                            kProtocolVersion + 1, kProtocolVersion)));
}

}  // namespace
}  // namespace dadrl
