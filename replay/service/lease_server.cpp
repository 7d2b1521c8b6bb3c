#include "replay/service/lease_server.h"

#include <algorithm>
#include <string>
#include <tuple>
#include <utility>

#include "common/util/log.h"
#include "common/util/random.h"
#include "common/util/shown.h"

namespace dadrl {
namespace {

// A time; beyond what the wire can mean, so that nothing overflows.
constexpr uint64_t kMaxIncarnation = uint64_t{1} << 63;

// Far below the term of a lease, far above the turn of a loop that gets its core.
constexpr Duration kDeafAfter = std::chrono::seconds(1);

// Who is turned away asks again for a while.
constexpr Duration kLogInterval = std::chrono::seconds(5);

std::string Who(const dadrl_idl_LeaseRequest& message) {
  return fmt::format("{}, pid {}", Shown(message.host, sizeof(message.host)), message.pid);
}

uint32_t RandomFirstAny(const Clock& clock) {
  Random random(static_cast<uint64_t>(clock.WallTimeNs()));
  return LeaseTable::kFirstAny +
         static_cast<uint32_t>(random.Below(LeaseTable::kMaxNumber - LeaseTable::kFirstAny));
}

}  // namespace

Result<std::unique_ptr<LeaseServer>> LeaseServer::Create(const Transport& transport, const Config& config,
                                                         uint64_t schema, uint64_t least_incarnation,
                                                         const Clock& clock) {
  AnswerWriters answers;
  for (uint32_t group = 0; group < kAcknowledgementGroups; ++group) {
    DADRL_ASSIGN_OR_RETURN(answers[group], AnswerWriter::Create(transport, LeaseAnswerTopic({.low = group})));
  }
  DADRL_ASSIGN_OR_RETURN(auto requests, RequestReader::Create(transport, kLeaseRequestTopic));
  LeaseTable table(static_cast<uint32_t>(config.actor.count), RandomFirstAny(clock), clock.Now());
  return std::unique_ptr<LeaseServer>(new LeaseServer(std::move(requests), std::move(answers),
                                                      std::move(table), schema, least_incarnation, clock));
}

LeaseServer::LeaseServer(std::unique_ptr<RequestReader> requests, AnswerWriters answers, LeaseTable table,
                         uint64_t schema, uint64_t least_incarnation, const Clock& clock)
    : requests_(std::move(requests)),
      answers_(std::move(answers)),
      table_(std::move(table)),
      schema_(schema),
      least_incarnation_(least_incarnation),
      clock_(clock) {}

void LeaseServer::Serve() {
  const TimePoint now = clock_.Now();
  if (served_at_ && now - *served_at_ > kDeafAfter) deaf_ += now - *served_at_;
  served_at_ = now;
  requests_->Take(256, [this](const dadrl_idl_LeaseRequest& message) { OnRequest(message); });
}

void LeaseServer::OnRequest(const dadrl_idl_LeaseRequest& message) {
  const LeaseTable::Answer answer = Decide(message);
  if (answer.verdict == LeaseVerdict::kGranted && (message.incarnation != 0 || message.leaving)) return;
  Log(message, answer);
  dadrl_idl_LeaseAnswer sample{};
  sample.token_high = message.token_high;
  sample.token_low = message.token_low;
  sample.protocol = kProtocolVersion;
  sample.schema = schema_;
  sample.start = message.start;
  sample.verdict = static_cast<uint32_t>(answer.verdict);
  sample.number = answer.number;
  sample.incarnation = answer.incarnation;
  std::copy_n(answer.reason.data(), std::min(answer.reason.size(), sizeof(sample.reason) - 1), sample.reason);
  // If it is lost, the actor asks again.
  std::ignore = answers_[message.token_low % kAcknowledgementGroups]->Write(sample);
}

LeaseTable::Answer LeaseServer::Decide(const dadrl_idl_LeaseRequest& message) {
  if (message.protocol != kProtocolVersion) {
    return {
        .verdict = LeaseVerdict::kIncompatible,
        .reason = fmt::format("the actor speaks version {} of the protocol, the replay {}: install the same "
                              "version of dadrl on both machines",
                              message.protocol, kProtocolVersion)};
  }
  if (message.schema != schema_) {
    return {.verdict = LeaseVerdict::kIncompatible,
            .reason = fmt::format("the actor's steps have schema {:#x}, the replay holds {:#x}: start the "
                                  "actor with the configuration of the run",
                                  message.schema, schema_)};
  }
  LeaseTable::Request request{.token = {message.token_high, message.token_low},
                              .start = std::min<uint64_t>(message.start, kMaxIncarnation),
                              .number = std::nullopt,
                              .incarnation = std::min<uint64_t>(message.incarnation, kMaxIncarnation),
                              .leaving = message.leaving,
                              .who = Who(message)};
  // What is too large for a number is one that nobody has.
  if (message.number >= 0) {
    request.number = static_cast<uint32_t>(std::min<int64_t>(message.number, LeaseTable::kMaxNumber + 1));
  }
  return table_.Ask(request, clock_.Now() - deaf_,
                    std::max(least_incarnation_, static_cast<uint64_t>(clock_.WallTimeNs())));
}

void LeaseServer::Log(const dadrl_idl_LeaseRequest& message, const LeaseTable::Answer& answer) {
  const bool refused = answer.verdict != LeaseVerdict::kGranted && answer.verdict != LeaseVerdict::kWait;
  if (!refused || clock_.Now() < next_log_) return;
  next_log_ = clock_.Now() + kLogInterval;
  spdlog::warn("turned away {}: {}", Who(message), answer.reason);
}

}  // namespace dadrl
