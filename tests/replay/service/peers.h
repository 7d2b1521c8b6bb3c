// The replay's two neighbours, as small as they can be, over real DDS.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <vector>

#include "common/dds/node.h"
#include "common/port/port.h"
#include "proto/topics.h"
#include "tests/replay/service/peer_actor.h"

namespace dadrl {

// Asks for one batch at a time.
class PeerLearner {
 public:
  struct Reply {
    std::vector<std::byte> bytes;  // empty: withheld
    uint64_t frames_held = 0;
    uint64_t frames_inserted = 0;
  };

  PeerLearner(const Transport& transport, uint64_t incarnation, int n_step)
      : incarnation_(incarnation), n_step_(n_step) {
    replies_ = Reader<dadrl_idl_BatchReply>::Create(transport, kBatchReplyTopic).value();
    requests_ = Writer<dadrl_idl_BatchRequest>::Create(transport, kBatchRequestTopic).value();
    priorities_ = Writer<dadrl_idl_PriorityUpdate>::Create(transport, kPriorityTopic).value();
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
    if (number == 0) number = ++last_;
    EXPECT_TRUE(Request(batch_size, number));
    return number;
  }
  // Asks, without caring whether anybody hears it, and takes what is there.
  void Disturb(uint32_t batch_size) {
    static_cast<void>(Request(batch_size, ++last_));
    RepliesTo(last_);
    replies_by_request_.clear();
  }
  // All replies so far to a request, in order.
  const std::vector<Reply>& RepliesTo(uint64_t number) {
    replies_->Take(100, [this](const dadrl_idl_BatchReply& reply) {
      const auto* bytes = reinterpret_cast<const std::byte*>(reply.bytes._buffer);
      if (reply.bytes._length > 0) batches_.push_back(reply.request);
      replies_by_request_[reply.request].push_back(
          {{bytes, bytes + reply.bytes._length}, reply.frames_held, reply.frames_inserted});
    });
    return replies_by_request_[number];
  }
  // The requests whose batches came, in that order.
  const std::vector<uint64_t>& batches() const { return batches_; }
  // Tells the replay that the item `key` has this priority.
  void SetPriority(uint64_t key, float priority) {
    dadrl_idl_PriorityUpdate update{};
    update.learner = incarnation_;
    update.keys = {1, 1, &key, false};
    update.priorities = {1, 1, &priority, false};
    EXPECT_TRUE(priorities_->Write(update));
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
  bool Request(uint32_t batch_size, uint64_t number) {
    dadrl_idl_BatchRequest request{};
    request.learner = incarnation_;
    request.request = number;
    request.protocol = kProtocolVersion;
    request.trajectories = batch_size;
    request.steps = static_cast<uint32_t>(n_step_);
    request.schema = SchemaHash(kTestSpec);
    return requests_->Write(request).has_value();
  }

  const uint64_t incarnation_;
  const int n_step_;
  uint64_t last_ = 0;
  std::unique_ptr<Reader<dadrl_idl_BatchReply>> replies_;
  std::unique_ptr<Writer<dadrl_idl_BatchRequest>> requests_;
  std::unique_ptr<Writer<dadrl_idl_PriorityUpdate>> priorities_;
  std::map<uint64_t, std::vector<Reply>> replies_by_request_;
  std::vector<uint64_t> batches_;
};

}  // namespace dadrl
