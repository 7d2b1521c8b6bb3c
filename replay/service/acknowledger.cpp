#include "replay/service/acknowledger.h"

#include <algorithm>

#include "common/util/log.h"

namespace dadrl {

Result<std::unique_ptr<Acknowledger>> Acknowledger::Create(const dds::Node& node, uint32_t shard) {
  Writers writers;
  for (uint32_t group = 0; group < kAcknowledgementGroups; ++group) {
    DADRL_ASSIGN_OR_RETURN(writers[group],
                           dds::Writer<dadrl_idl_Acknowledgement>::Create(node, AcknowledgementTopic(group)));
  }
  return std::unique_ptr<Acknowledger>(new Acknowledger(std::move(writers), shard));
}

void Acknowledger::Note(const SequenceTable::Stream& stream) {
  Actor& actor = actors_[stream.actor];
  actor.incarnation = stream.incarnation;
  actor.stored = stream.stored;
  actor.due = true;
  any_due_ = true;
}

void Acknowledger::SetGrant(Grant grant) {
  if (grant == grant_) return;
  grant_ = grant;
  for (auto& [id, actor] : actors_) actor.due = true;
  any_due_ = !actors_.empty();
}

bool Acknowledger::Publish(TimePoint now) {
  if (!any_due_) return false;
  any_due_ = false;
  for (auto& [id, actor] : actors_) {
    if (!actor.due) continue;
    const bool lately = actor.sent != TimePoint{} && now - actor.sent < kMinInterval;
    if (lately && actor.stored < actor.sent_stored + std::max<uint64_t>(1, grant_.chunks / 2)) {
      any_due_ = true;
      continue;
    }
    dadrl_idl_Acknowledgement message{};
    message.shard = shard_;
    message.actor = id;
    message.incarnation = actor.incarnation;
    message.stored_sequence = actor.stored;
    message.granted_sequence = actor.stored + grant_.chunks;
    if (const Status sent = writers_[id % kAcknowledgementGroups]->Write(message); !sent) {
      spdlog::warn("acknowledgement to actor {} was not sent: {}", id, sent.error().message);
      any_due_ = true;
      continue;
    }
    actor.sent = now;
    actor.sent_stored = actor.stored;
    actor.due = false;
  }
  return any_due_;
}

}  // namespace dadrl
