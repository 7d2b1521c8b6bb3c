// A replay shard that answers only when the test says so.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/port/port.h"
#include "common/step/driving_shape.h"
#include "proto/topics.h"
#include "proto/trajectory_codec.h"
#include "tests/proto/synthetic_experience.h"

namespace dadrl {

// Batches as a replay encodes them: item i has the key `first_key` + i.
class BatchMaker {
 public:
  explicit BatchMaker(const DrivingShape& spec) : schema_(SchemaHash(spec)) {
    Random random(5);
    PayloadCodec codec(spec, FloatCoding::kFloat32);
    codec.Encode(SyntheticObservation(spec, random), frame_);
  }
  std::vector<std::byte> Make(int size, uint64_t first_key, uint32_t policy_version = 1,
                              const std::vector<float>& rewards = {1.0f, 0.5f}) const {
    const Action action{0.5f, -0.5f};
    std::vector<SampledStep> steps;
    for (const float reward : rewards)
      steps.push_back({policy_version, reward, std::as_bytes(std::span(action))});
    const std::span<const std::byte> payloads[] = {frame_, frame_};
    std::vector<SampledTrajectory> trajectories;
    for (int i = 0; i < size; ++i) {
      trajectories.push_back(
          {.key = first_key + static_cast<uint64_t>(i), .steps = steps, .payloads = payloads});
    }
    const TrajectoryShape shape{.count = size, .steps = static_cast<int>(rewards.size())};
    return EncodeTrajectories(trajectories, shape, schema_);
  }

 private:
  uint64_t schema_;
  std::vector<std::byte> frame_;
};

// The replay's end of the wire. Dies and comes back with the object.
class TestShard {
 public:
  TestShard(const Transport& transport, int index)
      : requests_(Reader<dadrl_idl_BatchRequest>::Create(transport, kBatchRequestTopic).value()),
        replies_(Writer<dadrl_idl_BatchReply>::Create(transport, kBatchReplyTopic).value()),
        priorities_(Reader<dadrl_idl_PriorityUpdate>::Create(transport, kPriorityTopic).value()),
        index_(static_cast<uint32_t>(index)) {}

  // Requests for this shard that have come so far and were not returned before.
  std::vector<dadrl_idl_BatchRequest> TakeRequests() {
    std::vector<dadrl_idl_BatchRequest> requests;
    requests_->Take(100, [&](const dadrl_idl_BatchRequest& request) {
      if (request.shard == index_) requests.push_back(request);
    });
    return requests;
  }
  // Over DDS it fails while a learner that was killed still counts as there.
  Status Reply(uint64_t learner, uint64_t request, std::span<const std::byte> bytes, int claimed_shard = -1) {
    dadrl_idl_BatchReply reply{};
    reply.shard = claimed_shard < 0 ? index_ : static_cast<uint32_t>(claimed_shard);
    reply.learner = learner;
    reply.request = request;
    reply.frames_held = 1000;
    const auto length = static_cast<uint32_t>(bytes.size());
    auto* buffer = reinterpret_cast<uint8_t*>(const_cast<std::byte*>(bytes.data()));
    reply.bytes = {length, length, buffer, false};
    return replies_->Write(reply);
  }
  Status Refuse(uint64_t learner, uint64_t request, const std::string& reason) {
    dadrl_idl_BatchReply reply{};
    reply.shard = index_;
    reply.learner = learner;
    reply.request = request;
    reason.copy(reply.refusal, sizeof(reply.refusal) - 1);
    return replies_->Write(reply);
  }
  Reader<dadrl_idl_PriorityUpdate>& priorities() { return *priorities_; }

 private:
  std::unique_ptr<Reader<dadrl_idl_BatchRequest>> requests_;
  std::unique_ptr<Writer<dadrl_idl_BatchReply>> replies_;
  std::unique_ptr<Reader<dadrl_idl_PriorityUpdate>> priorities_;
  uint32_t index_;
};

}  // namespace dadrl
