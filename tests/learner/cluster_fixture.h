// A learner's node and a replay shard's, in one process over real DDS on loopback. The shard answers only
// when the test says so.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "proto/topics.h"
#include "proto/trajectory_codec.h"
#include "tests/common/dds/dds_fixture.h"
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
  TestShard(const ClusterConfig& cluster, int shards, int index)
      : node_(dds::Node::Create(cluster, shards, dds::Role::kReplay, index).value()),
        requests_(dds::Reader<dadrl_idl_BatchRequest>::Create(*node_, kBatchRequestTopic).value()),
        replies_(dds::Writer<dadrl_idl_BatchReply>::Create(*node_, kBatchReplyTopic).value()),
        priorities_(dds::Reader<dadrl_idl_PriorityUpdate>::Create(*node_, kPriorityTopic).value()),
        index_(static_cast<uint32_t>(index)) {}

  // Requests for this shard that have come so far and were not returned before.
  std::vector<dadrl_idl_BatchRequest> TakeRequests() {
    std::vector<dadrl_idl_BatchRequest> requests;
    requests_->Take(100, [&](const dadrl_idl_BatchRequest& request) {
      if (request.shard == index_) requests.push_back(request);
    });
    return requests;
  }
  // Waits for at least `count` requests.
  std::vector<dadrl_idl_BatchRequest> AwaitRequests(size_t count) {
    std::vector<dadrl_idl_BatchRequest> requests;
    EXPECT_TRUE(Eventually([&] {
      for (const auto& request : TakeRequests()) requests.push_back(request);
      return requests.size() >= count;
    }));
    return requests;
  }
  void Reply(uint64_t learner, uint64_t request, std::span<const std::byte> bytes, int claimed_shard = -1) {
    // The reader may have been discovered a moment after the writer.
    ASSERT_TRUE(Eventually([&] { return replies_->matched() > 0; }));
    ASSERT_TRUE(TryReply(learner, request, bytes, claimed_shard));
  }
  // Fails while a learner that was killed still counts as there.
  Status TryReply(uint64_t learner, uint64_t request, std::span<const std::byte> bytes,
                  int claimed_shard = -1) {
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
  void Refuse(uint64_t learner, uint64_t request, const std::string& reason) {
    ASSERT_TRUE(Eventually([&] { return replies_->matched() > 0; }));
    dadrl_idl_BatchReply reply{};
    reply.shard = index_;
    reply.learner = learner;
    reply.request = request;
    reason.copy(reply.refusal, sizeof(reply.refusal) - 1);
    ASSERT_TRUE(replies_->Write(reply));
  }
  dds::Reader<dadrl_idl_PriorityUpdate>& priorities() { return *priorities_; }

 private:
  std::unique_ptr<dds::Node> node_;
  std::unique_ptr<dds::Reader<dadrl_idl_BatchRequest>> requests_;
  std::unique_ptr<dds::Writer<dadrl_idl_BatchReply>> replies_;
  std::unique_ptr<dds::Reader<dadrl_idl_PriorityUpdate>> priorities_;
  uint32_t index_;
};

}  // namespace dadrl
