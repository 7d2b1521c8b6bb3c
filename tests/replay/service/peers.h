// The replay's two neighbours, as small as they can be, over real DDS.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "common/dds/endpoint.h"
#include "common/dds/node.h"
#include "common/util/clock.h"
#include "proto/topics.h"
#include "tests/replay/test_chunks.h"

namespace dadrl {

// Polls until `condition` holds; false after `limit_s`, which is generous: machines are busy.
inline bool Eventually(const std::function<bool()>& condition, double limit_s = 30.0) {
  SystemClock clock;
  for (const TimePoint end = clock.Now() + FromSeconds(limit_s); clock.Now() < end;) {
    if (condition()) return true;
    clock.SleepFor(std::chrono::milliseconds(1));
  }
  return condition();
}

// Keeps chunks 1, 2, 3, ... until they are acknowledged, and sends them in order as far as it is granted;
// from the first unacknowledged again when the replay is another one or has been silent for a while.
class PeerActor {
 public:
  PeerActor(const dds::Node& node, uint32_t id, uint64_t incarnation) : id_(id), incarnation_(incarnation) {
    acknowledgements_ = dds::Reader<dadrl_idl_Acknowledgement>::Create(node, kAcknowledgementTopic).value();
    chunks_ = dds::Writer<dadrl_idl_ChunkMessage>::Create(node, ChunkTopic(0)).value();
  }

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
      if (!Send(kept_[next_ - 1], stored_ + 1)) return;
    }
  }
  bool Send(std::vector<std::byte>& bytes, uint64_t oldest_kept) {
    dadrl_idl_ChunkMessage message{};
    message.actor = id_;
    message.oldest_kept = oldest_kept;
    message.bytes._buffer = reinterpret_cast<uint8_t*>(bytes.data());
    message.bytes._length = message.bytes._maximum = static_cast<uint32_t>(bytes.size());
    return chunks_->Write(message).has_value();
  }
  bool PumpUntilStored(uint64_t sequence, double limit_s = 30.0) {
    return Eventually([&] { return Pump(), stored_ >= sequence; }, limit_s);
  }
  bool connected() const { return chunks_->matched() > 0 && acknowledgements_->matched() > 0; }
  uint64_t produced() const { return kept_.size(); }
  uint64_t stored() const { return stored_; }
  uint64_t granted() const { return granted_; }

 private:
  const uint32_t id_;
  const uint64_t incarnation_;
  SystemClock clock_;
  std::unique_ptr<dds::Reader<dadrl_idl_Acknowledgement>> acknowledgements_;
  std::unique_ptr<dds::Writer<dadrl_idl_ChunkMessage>> chunks_;
  std::vector<std::vector<std::byte>> kept_;
  uint64_t stored_ = 0;
  uint64_t granted_ = 1;
  uint64_t next_ = 1;
  uint64_t generation_ = 0;
  TimePoint heard_at_ = clock_.Now();
};

// Asks for one batch at a time.
class PeerLearner {
 public:
  struct Reply {
    std::vector<std::byte> bytes;  // empty: withheld
    uint64_t frames_held = 0;
    uint64_t frames_inserted = 0;
  };

  PeerLearner(const dds::Node& node, uint64_t incarnation, int n_step)
      : incarnation_(incarnation), n_step_(n_step) {
    replies_ = dds::Reader<dadrl_idl_BatchReply>::Create(node, kBatchReplyTopic).value();
    requests_ = dds::Writer<dadrl_idl_BatchRequest>::Create(node, kBatchRequestTopic).value();
    priorities_ = dds::Writer<dadrl_idl_PriorityUpdate>::Create(node, kPriorityTopic).value();
  }

  // Only once the dead one is forgotten is a new one told apart from it.
  bool WaitForNoReplay() {
    return Eventually([&] { return requests_->matched() == 0 && replies_->matched() == 0; });
  }
  bool WaitForReplay() {
    return Eventually([&] { return requests_->matched() > 0 && replies_->matched() > 0; });
  }
  // The request's number.
  uint64_t Ask(uint32_t batch_size, uint64_t number = 0) {
    dadrl_idl_BatchRequest request{};
    request.learner = incarnation_;
    request.request = number != 0 ? number : ++last_;
    request.batch_size = batch_size;
    request.n_step = static_cast<uint32_t>(n_step_);
    request.schema = SchemaHash(kTestSpec);
    EXPECT_TRUE(requests_->Write(request));
    return request.request;
  }
  // All replies so far to a request, in order.
  const std::vector<Reply>& RepliesTo(uint64_t number) {
    replies_->Take(100, [this](const dadrl_idl_BatchReply& reply) {
      const auto* bytes = reinterpret_cast<const std::byte*>(reply.bytes._buffer);
      replies_by_request_[reply.request].push_back(
          {{bytes, bytes + reply.bytes._length}, reply.frames_held, reply.frames_inserted});
    });
    return replies_by_request_[number];
  }
  // Waits for the request's batch; empty when it does not come.
  Reply Fetch(uint32_t batch_size) {
    const uint64_t number = Ask(batch_size);
    Reply batch;
    Eventually([&] {
      for (const Reply& reply : RepliesTo(number)) {
        if (!reply.bytes.empty()) batch = reply;
      }
      return !batch.bytes.empty();
    });
    return batch;
  }

 private:
  const uint64_t incarnation_;
  const int n_step_;
  uint64_t last_ = 0;
  std::unique_ptr<dds::Reader<dadrl_idl_BatchReply>> replies_;
  std::unique_ptr<dds::Writer<dadrl_idl_BatchRequest>> requests_;
  std::unique_ptr<dds::Writer<dadrl_idl_PriorityUpdate>> priorities_;
  std::map<uint64_t, std::vector<Reply>> replies_by_request_;
};

}  // namespace dadrl
