#include "actor/experience/experience_writer.h"

#include <algorithm>
#include <utility>

#include "common/util/log.h"
#include "common/util/shown.h"
#include "proto/borrowed_sequence.h"

namespace dadrl {
namespace {

// How soon a replay that comes or goes is noticed.
constexpr Duration kPeerPoll = std::chrono::milliseconds(50);

}  // namespace

ExperienceWriter::ExperienceWriter(const Config& config, uint32_t actor, uint64_t incarnation,
                                   const Clock& clock, LeaseHolder* lease)
    : ChunkingSink(config, actor, incarnation),
      actor_(actor),
      incarnation_(incarnation),
      lease_(lease),
      shard_(actor % static_cast<uint32_t>(config.replay.shards)),
      max_backlog_bytes_(config.actor.max_unacknowledged_bytes),
      clock_(clock) {}

Result<std::unique_ptr<ExperienceWriter>> ExperienceWriter::Create(const Transport& transport,
                                                                   const Config& config, uint32_t actor,
                                                                   uint64_t incarnation, const Clock& clock,
                                                                   LeaseHolder* lease) {
  std::unique_ptr<ExperienceWriter> writer(new ExperienceWriter(config, actor, incarnation, clock, lease));
  DADRL_ASSIGN_OR_RETURN(writer->acknowledgements_,
                         AcknowledgementReader::Create(transport, AcknowledgementTopic(actor)));
  DADRL_ASSIGN_OR_RETURN(writer->chunks_,
                         ChunkWriter::Create(transport, ChunkTopic(static_cast<int>(writer->shard_))));
  return writer;
}

void ExperienceWriter::Start() {
  sender_ = std::thread([this] {
    while (!stopping_) Step();
  });
}

ExperienceWriter::~ExperienceWriter() {
  stopping_ = true;
  if (!sender_.joinable()) return;
  acknowledgements_->Wake();
  sender_.join();
}

void ExperienceWriter::OnChunk(uint64_t sequence, std::vector<std::byte> bytes) {
  {
    MutexLock lock(mutex_);
    statistics_.chunks = sequence;
    statistics_.backlog_bytes += static_cast<int64_t>(bytes.size());
    produced_.push_back({.sequence = sequence, .bytes = std::move(bytes)});
  }
  acknowledgements_->Wake();
}

bool ExperienceWriter::blocked() const {
  MutexLock lock(mutex_);
  if (!status_) return false;
  if (statistics_.backlog_bytes >= max_backlog_bytes_) return true;
  return statistics_.replay_present && statistics_.chunks > statistics_.granted + kAhead;
}

bool ExperienceWriter::Flush(Duration timeout) {
  EndEpisode();
  const TimePoint deadline = clock_.Now() + timeout;
  while (status() && statistics().acknowledged < last_sequence()) {
    const Duration left = deadline - clock_.Now();
    if (left <= Duration::zero()) break;
    if (sender_.joinable()) {
      AwaitAcknowledgement(left);
    } else {
      Step();
    }
  }
  return statistics().acknowledged == last_sequence();
}

void ExperienceWriter::AwaitAcknowledgement(Duration timeout) {
  MutexLock lock(mutex_);
  if (status_ && statistics_.acknowledged < last_sequence()) acknowledged_changed_.WaitFor(mutex_, timeout);
}

ExperienceWriter::Statistics ExperienceWriter::statistics() const {
  MutexLock lock(mutex_);
  return statistics_;
}

void ExperienceWriter::Step() {
  TakeProduced();
  TakeAcknowledgements();
  NoticePeer();
  Publish();
  if (ShowLease()) {
    SendOrWait();
  } else {
    acknowledgements_->Wait(kPeerPoll);
  }
}

bool ExperienceWriter::ShowLease() {
  if (lease_ != nullptr && !lease_->Step(clock_.Now()))
    End(Fail(ErrorCode::kExhausted, "{}", lease_->lost()));
  return status().has_value();
}

void ExperienceWriter::TakeProduced() {
  std::vector<Backlog::Chunk> produced;
  {
    MutexLock lock(mutex_);
    produced.swap(produced_);
  }
  for (Backlog::Chunk& chunk : produced) backlog_.Add(std::move(chunk));
}

void ExperienceWriter::TakeAcknowledgements() {
  acknowledgements_->Take(1 << 20, [this](const dadrl_idl_Acknowledgement& ack) {
    if (ack.actor == actor_ && ack.shard == shard_) OnAcknowledgement(ack);
  });
}

void ExperienceWriter::OnAcknowledgement(const dadrl_idl_Acknowledgement& ack) {
  if (ack.incarnation > incarnation_) {
    End(Fail(
        ErrorCode::kExhausted,
        "actor number {} belongs to another process by now: replay shard {} takes chunks of its incarnation "
        "{}, this one is {}",
        actor_, shard_, ack.incarnation, incarnation_));
  }
  if (ack.incarnation != incarnation_) return;
  CountRefusals(ack);
  const uint64_t before = backlog_.acknowledged();
  switch (backlog_.OnAcknowledgement(ack.stored_sequence, ack.granted_sequence, clock_.Now())) {
    case Backlog::AckEffect::kAccepted:
      invalid_since_ = {};
      break;
    case Backlog::AckEffect::kForgotten:
      if (std::exchange(forgotten_reported_, true)) break;
      spdlog::warn("replay shard {} has forgotten this actor's chunks {} to {}: they are lost", shard_,
                   ack.stored_sequence + 1, before);
      break;
    case Backlog::AckEffect::kInvalid:
      OnInvalid(ack);
      break;
  }
}

void ExperienceWriter::CountRefusals(const dadrl_idl_Acknowledgement& ack) {
  const uint64_t before = std::exchange(refused_there_, ack.refused);
  if (ack.refused == before) return;
  const auto fault = static_cast<ChunkFault>(ack.refusal);
  if (fault == ChunkFault::kStale) {
    return End(
        Fail(ErrorCode::kExhausted, "replay shard {}: {}", shard_, Shown(ack.reason, sizeof(ack.reason))));
  }
  if (refused_ == 0) {
    spdlog::error("replay shard {} refuses chunk {} for good ({}): {}; it is dropped, more are counted",
                  shard_, ack.refused_sequence, ChunkFaultName(fault), Shown(ack.reason, sizeof(ack.reason)));
  }
  // A shard that was restarted counts anew.
  refused_ += ack.refused > before ? ack.refused - before : ack.refused;
}

void ExperienceWriter::OnInvalid(const dadrl_idl_Acknowledgement& ack) {
  if (invalid_acknowledgements_++ == 0) {
    spdlog::warn("replay shard {} acknowledges chunk {}, but this actor made only {}: ignored", shard_,
                 ack.stored_sequence, backlog_.last_sequence());
  }
  if (invalid_since_ == TimePoint{}) invalid_since_ = clock_.Now();
  if (clock_.Now() - invalid_since_ < kInvalidLimit) return;
  End(Fail(
      ErrorCode::kCorrupt,
      "replay shard {} acknowledges chunk {} of actor {}, which made only {}: another sends under its number",
      shard_, ack.stored_sequence, actor_, backlog_.last_sequence()));
}

void ExperienceWriter::End(Status why) {
  MutexLock lock(mutex_);
  if (status_) status_ = std::move(why);
}

Status ExperienceWriter::status() const {
  MutexLock lock(mutex_);
  return status_;
}

void ExperienceWriter::NoticePeer() {
  const uint64_t generation = chunks_->match_generation();
  if (generation == match_generation_) return;
  match_generation_ = generation;
  forgotten_reported_ = false;
  backlog_.OnNewPeer(clock_.Now());
}

void ExperienceWriter::SendOrWait() {
  const Backlog::Chunk* chunk = chunks_->matched() > 0 ? backlog_.Next(clock_.Now()) : nullptr;
  if (chunk == nullptr) {
    acknowledgements_->Wait(kPeerPoll);
    return;
  }
  dadrl_idl_ChunkMessage message{};
  message.actor = actor_;
  message.incarnation = incarnation_;
  message.chunk_sequence = chunk->sequence;
  message.oldest_kept = backlog_.oldest_kept();
  Borrow(chunk->bytes, message.bytes);
  const Status sent = chunks_->Write(message);
  if (sent) {
    backlog_.OnSent(clock_.Now());
  } else if (sent.error().code != ErrorCode::kUnavailable) {
    spdlog::error("chunk {} was not sent: {}", chunk->sequence, sent.error().message);
    acknowledgements_->Wait(std::chrono::seconds(1));
  }
}

void ExperienceWriter::Publish() {
  MutexLock lock(mutex_);
  int64_t bytes = static_cast<int64_t>(backlog_.bytes());
  for (const Backlog::Chunk& chunk : produced_) bytes += static_cast<int64_t>(chunk.bytes.size());
  statistics_.backlog_bytes = bytes;
  statistics_.acknowledged = backlog_.acknowledged();
  statistics_.granted = backlog_.granted();
  statistics_.resent = backlog_.resent_chunks();
  statistics_.refused = refused_;
  statistics_.invalid_acknowledgements = invalid_acknowledgements_;
  statistics_.replay_present = chunks_->matched() > 0;
  acknowledged_changed_.NotifyAll();
}

}  // namespace dadrl
