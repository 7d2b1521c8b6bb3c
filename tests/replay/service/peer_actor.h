// An actor as small as it can be, over real DDS.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/dds/node.h"
#include "common/port/port.h"
#include "common/util/clock.h"
#include "proto/topics.h"
#include "tests/common/util/eventually.h"
#include "tests/replay/test_chunks.h"

namespace dadrl {

// Keeps chunks 1, 2, 3, ... until they are acknowledged, and sends them in order as far as it is granted;
// from the first unacknowledged again when the replay is another one or has been silent for a while.
class PeerActor {
 public:
  PeerActor(const Transport& transport, uint32_t id, uint64_t incarnation, int shard = 0)
      : id_(id), incarnation_(incarnation) {
    acknowledgements_ =
        Reader<dadrl_idl_Acknowledgement>::Create(transport, AcknowledgementTopic(id)).value();
    chunks_ = Writer<dadrl_idl_ChunkMessage>::Create(transport, ChunkTopic(shard)).value();
  }

  // A chunk as no sane actor makes it.
  void AddRaw(std::vector<std::byte> bytes) { kept_.push_back(std::move(bytes)); }
  void Add(TestChunk chunk) {
    chunk.identity = {id_, incarnation_, kept_.size() + 1};
    kept_.push_back(Build(chunk));
  }
  // Hears and sends what it can now.
  void Pump() {
    acknowledgements_->Take(1000, [this](const dadrl_idl_Acknowledgement& ack) {
      if (ack.actor != id_ || ack.incarnation != incarnation_) return;
      if (ack.stored_sequence > stored_) heard_at_ = clock_.Now();
      stored_ = std::max<uint64_t>(stored_, ack.stored_sequence);
      if (ack.refused > refused_) refusal_ = {static_cast<ChunkFault>(ack.refusal), ack.reason};
      refused_ = ack.refused;
      granted_ = ack.granted_sequence;
      next_ = std::max(next_, stored_ + 1);
    });
    const uint64_t generation = chunks_->match_generation();
    if (generation != generation_ || clock_.Now() - heard_at_ > std::chrono::milliseconds(500)) {
      generation_ = generation;
      heard_at_ = clock_.Now();
      next_ = stored_ + 1;
      granted_ = std::max(granted_, next_);
    }
    for (; chunks_->matched() > 0 && next_ <= kept_.size() && next_ <= granted_; ++next_) {
      if (!Send(kept_[next_ - 1], stored_ + 1, next_)) {
        ++refused_writes_;
        return;
      }
    }
  }
  // `sequence`: that the message names; 0 for none.
  bool Send(std::vector<std::byte>& bytes, uint64_t oldest_kept, uint64_t sequence = 0) {
    dadrl_idl_ChunkMessage message{};
    message.actor = id_;
    message.incarnation = incarnation_;
    message.chunk_sequence = sequence;
    message.oldest_kept = oldest_kept;
    message.bytes._buffer = reinterpret_cast<uint8_t*>(bytes.data());
    message.bytes._length = message.bytes._maximum = static_cast<uint32_t>(bytes.size());
    return chunks_->Write(message).has_value();
  }
  bool PumpUntilStored(uint64_t sequence, double limit_s = 30.0) {
    return Eventually([&] { return Pump(), stored_ >= sequence; }, std::chrono::duration<double>(limit_s));
  }
  bool connected() const { return chunks_->matched() > 0 && acknowledgements_->matched() > 0; }
  uint32_t id() const { return id_; }
  // As it was sent; 1 is the first.
  const std::vector<std::byte>& chunk(uint64_t sequence) const { return kept_[sequence - 1]; }
  uint64_t produced() const { return kept_.size(); }
  uint64_t stored() const { return stored_; }
  uint64_t granted() const { return granted_; }
  // Chunks refused for good, as the replay counts them, and why the last was.
  uint64_t refused() const { return refused_; }
  const std::pair<ChunkFault, std::string>& refusal() const { return refusal_; }
  // That found no room at the replay in time.
  uint64_t refused_writes() const { return refused_writes_; }

 private:
  const uint32_t id_;
  const uint64_t incarnation_;
  SystemClock clock_;
  std::unique_ptr<Reader<dadrl_idl_Acknowledgement>> acknowledgements_;
  std::unique_ptr<Writer<dadrl_idl_ChunkMessage>> chunks_;
  std::vector<std::vector<std::byte>> kept_;
  uint64_t stored_ = 0;
  uint64_t granted_ = 1;
  uint64_t next_ = 1;
  uint64_t generation_ = 0;
  uint64_t refused_ = 0;
  std::pair<ChunkFault, std::string> refusal_;
  uint64_t refused_writes_ = 0;
  TimePoint heard_at_ = clock_.Now();
};

}  // namespace dadrl
