#include "replay/service/acknowledger.h"

#include <algorithm>
#include <tuple>

#include "common/liveness/working_thread.h"
#include "common/util/log.h"

namespace dadrl {

Result<std::unique_ptr<Acknowledger>> Acknowledger::Create(const Transport& transport, uint32_t shard) {
  Writers writers;
  for (uint32_t group = 0; group < kAcknowledgementGroups; ++group) {
    DADRL_ASSIGN_OR_RETURN(writers[group],
                           Writer<dadrl_idl_Acknowledgement>::Create(transport, AcknowledgementTopic(group)));
  }
  return std::unique_ptr<Acknowledger>(new Acknowledger(std::move(writers), shard));
}

void Acknowledger::Note(const SequenceTable::Stream& stream) {
  Actor& actor = actors_[stream.actor];
  if (actor.incarnation != stream.incarnation) actor.refused = actor.refused_sequence = 0;
  actor.incarnation = stream.incarnation;
  actor.stored = stream.stored;
  actor.due = true;
  any_due_ = true;
}

void Acknowledger::Refuse(const ChunkIdentity& identity, const ChunkRefusal& refusal) {
  const auto found = actors_.find(identity.actor);
  if (found != actors_.end() && found->second.incarnation > identity.incarnation)
    return;  // is told of that one
  if (found == actors_.end() || found->second.incarnation < identity.incarnation) {
    // Of an actor that has no stream here. If the word of it is lost, its chunk comes again.
    Actor stranger{.incarnation = identity.incarnation,
                   .refused = 1,
                   .refused_sequence = identity.sequence,
                   .refusal = refusal};
    std::ignore = Send(MessageTo(identity.actor, stranger));
    return;
  }
  Actor& actor = found->second;
  if (identity.sequence > actor.refused_sequence) ++actor.refused;
  actor.refused_sequence = std::max(actor.refused_sequence, identity.sequence);
  actor.refusal = refusal;
  actor.due = any_due_ = true;
}

void Acknowledger::Hear(uint32_t actor, TimePoint now) {
  const auto found = actors_.find(actor);
  if (found == actors_.end()) return;
  TimePoint& heard = found->second.heard;
  if (heard == TimePoint{} || now - heard > kActive) ++active_;
  heard = now;
}

uint64_t Acknowledger::Share(uint64_t window, TimePoint now) {
  if (now - counted_ > kActive / 2) {
    counted_ = now;
    active_ = static_cast<size_t>(std::count_if(actors_.begin(), actors_.end(), [now](const auto& entry) {
      return entry.second.heard != TimePoint{} && now - entry.second.heard <= kActive;
    }));
  }
  const uint64_t share = kChunkReaderSamples / std::max<uint64_t>(1, active_);
  return std::clamp<uint64_t>(share, 1, window);
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
    Beat();  // many actors, each with a bounded wait
    const bool lately = actor.sent != TimePoint{} && now - actor.sent < kMinInterval;
    if (lately && actor.stored < actor.sent_stored + std::max<uint64_t>(1, grant_.chunks / 2)) {
      any_due_ = true;
      continue;
    }
    if (const Status sent = Send(MessageTo(id, actor)); !sent) {
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

dadrl_idl_Acknowledgement Acknowledger::MessageTo(uint32_t id, const Actor& actor) const {
  dadrl_idl_Acknowledgement message{};
  message.shard = shard_;
  message.actor = id;
  message.incarnation = actor.incarnation;
  message.stored_sequence = actor.stored;
  message.granted_sequence = actor.stored + grant_.chunks;
  message.refused = actor.refused;
  message.refused_sequence = actor.refused_sequence;
  message.refusal = static_cast<uint32_t>(actor.refusal.fault);
  const std::string& reason = actor.refusal.reason;
  std::copy_n(reason.data(), std::min(reason.size(), sizeof(message.reason) - 1), message.reason);
  return message;
}

Status Acknowledger::Send(const dadrl_idl_Acknowledgement& message) {
  return writers_[message.actor % kAcknowledgementGroups]->Write(message);
}

}  // namespace dadrl
