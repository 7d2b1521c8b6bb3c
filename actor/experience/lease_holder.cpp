#include "actor/experience/lease_holder.h"

#include <unistd.h>

#include <tuple>

#include "common/util/shown.h"

namespace dadrl {
namespace {

constexpr Duration kAskInterval = std::chrono::milliseconds(500);
constexpr Duration kHearInterval = std::chrono::milliseconds(50);

}  // namespace

Result<std::unique_ptr<LeaseHolder>> LeaseHolder::Create(const Transport& transport, const Options& options,
                                                         const Clock& clock) {
  std::unique_ptr<LeaseHolder> holder(new LeaseHolder(options, clock));
  // The reader first: who is asked can already answer.
  DADRL_ASSIGN_OR_RETURN(holder->answers_, AnswerReader::Create(transport, LeaseAnswerTopic(options.token)));
  DADRL_ASSIGN_OR_RETURN(holder->requests_, RequestWriter::Create(transport, kLeaseRequestTopic));
  return holder;
}

LeaseHolder::~LeaseHolder() {
  if (lease_ && lost_.empty()) Ask(true);
}

Result<LeaseHolder::Lease> LeaseHolder::Acquire(const std::function<bool()>& idle) {
  std::optional<TimePoint> held_since;
  while (idle()) {
    const TimePoint now = clock_.Now();
    if (connected() && now >= next_) {
      Ask(false);
      next_ = now + kAskInterval;
    }
    answers_->Wait(kHearInterval);
    const auto answer = Hear();
    if (!answer) continue;
    switch (static_cast<LeaseVerdict>(answer->verdict)) {
      case LeaseVerdict::kGranted:
        lease_ = {.number = answer->number, .incarnation = answer->incarnation};
        next_ = now + kLeaseRenewal;
        return *lease_;
      case LeaseVerdict::kWait:
        break;
      case LeaseVerdict::kHeld:
        if (!held_since) held_since = now;
        if (now - *held_since < kPatience) break;
        [[fallthrough]];
      case LeaseVerdict::kLost:
        return Fail(ErrorCode::kExhausted, "{}", Shown(answer->reason, sizeof(answer->reason)));
      case LeaseVerdict::kIncompatible:
        return Fail(ErrorCode::kInvalidArgument, "the replay turns this actor away: {}",
                    Shown(answer->reason, sizeof(answer->reason)));
    }
  }
  return Fail(ErrorCode::kUnavailable, "stopped before the replay gave this actor a number");
}

bool LeaseHolder::Step(TimePoint now) {
  if (!lost_.empty() || !lease_) return lost_.empty();
  if (now < next_) return true;
  next_ = now + kLeaseRenewal;
  if (connected()) Ask(false);
  if (const auto answer = Hear()) {
    const auto verdict = static_cast<LeaseVerdict>(answer->verdict);
    if (verdict == LeaseVerdict::kLost || verdict == LeaseVerdict::kIncompatible) {
      lost_ = Shown(answer->reason, sizeof(answer->reason));
    }
  }
  return lost_.empty();
}

void LeaseHolder::Ask(bool leaving) {
  dadrl_idl_LeaseRequest message{};
  message.token_high = options_.token.high;
  message.token_low = options_.token.low;
  message.protocol = kProtocolVersion;
  message.schema = options_.schema;
  message.start = options_.start;
  message.number = lease_ ? lease_->number : options_.number ? static_cast<int64_t>(*options_.number) : -1;
  message.incarnation = lease_ ? lease_->incarnation : 0;
  message.leaving = leaving;
  message.pid = ::getpid();
  // Cut where the name is longer.
  ::gethostname(message.host, sizeof(message.host) - 1);
  // What is not sent is repeated.
  std::ignore = requests_->Write(message);
}

std::optional<dadrl_idl_LeaseAnswer> LeaseHolder::Hear() {
  std::optional<dadrl_idl_LeaseAnswer> newest;
  answers_->Take(16, [&](const dadrl_idl_LeaseAnswer& answer) {
    const bool ours = answer.token_high == options_.token.high && answer.token_low == options_.token.low &&
                      answer.start == options_.start;
    if (ours) newest = answer;
  });
  return newest;
}

}  // namespace dadrl
