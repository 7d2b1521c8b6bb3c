// A replay process of its own for each test, with one actor and one learner.
#pragma once

#include <gtest/gtest.h>

#include <map>

#include "common/dds/node.h"
#include "proto/trajectory_codec.h"
#include "tests/common/io/test_run_key.h"
#include "tests/driving_columns.h"
#include "tests/replay/service/peers.h"
#include "tests/replay/service/replay_process.h"

namespace dadrl {

inline constexpr int kFrames = 4;  // of a chunk; two chunks an episode

class ReplayServiceTest : public testing::Test {
 protected:
  ReplayServiceTest() {
    config_.observation.vehicles = kTestSpec.vehicles;
    config_.observation.history = kTestSpec.history;
    config_.algorithm.n_step = 1;
    config_.replay.min_size = 4;
    config_.replay.samples_per_insert = 0.0;
    config_.replay.max_times_sampled = 1;
    config_.cluster.lease_s = 3.0;
    config_.cluster.port = dds::FindFreePort().value();
  }
  // After the configuration is final.
  void Launch(std::optional<uint64_t> file_limit = std::nullopt) {
    replay_ = std::make_unique<ReplayProcess>(folder_.path() / "run", config_);
    replay_->Start(file_limit);
    actor_node_ = dds::Node::Create(config_.cluster, 1, dds::Role::kActor, 1, kTestRunKey).value();
    learner_node_ = dds::Node::Create(config_.cluster, 1, dds::Role::kLearner, 0, kTestRunKey).value();
    actor_ = std::make_unique<PeerActor>(*actor_node_, 1, 100);
    learner_ = std::make_unique<PeerLearner>(*learner_node_, 200, 1);
    ASSERT_TRUE(Eventually([&] { return actor_->connected(); })) << replay_->Log();
    ASSERT_TRUE(learner_->WaitForReplay());
  }
  void AddChunks(int count) {
    for (int i = 0; i < count; ++i) {
      const bool second = actor_->produced() % 2 == 1;
      actor_->Add({.episode = actor_->produced() / 2 + 1,
                   .first_frame = second ? kFrames : 0u,
                   .frames = kFrames,
                   .end = static_cast<uint8_t>(second ? kTerminated : 0)});
    }
  }
  // Samples all that is stored; how often each frame came, by its reward.
  std::map<float, int> SampleAll() {
    std::map<float, int> counts;
    TrajectoryDecoder decoder(kTestSpec, kTestBounds);
    for (uint64_t left = actor_->stored() * kFrames; left > 0;) {
      const auto size = static_cast<uint32_t>(std::min<uint64_t>(left, 100));
      const auto reply = learner_->Fetch(size);
      TrajectoryBatch batch(kTestSpec, {static_cast<int>(size)});
      const Status decoded = decoder.Decode(reply.bytes, batch);
      EXPECT_TRUE(decoded) << decoded.error().message;
      if (!decoded) break;
      for (const float reward : batch.rewards) ++counts[reward];
      left -= size;
    }
    return counts;
  }

  MemoryFolder folder_;
  Config config_;
  std::unique_ptr<ReplayProcess> replay_;
  std::unique_ptr<dds::Node> actor_node_;
  std::unique_ptr<dds::Node> learner_node_;
  std::unique_ptr<PeerActor> actor_;
  std::unique_ptr<PeerLearner> learner_;
};

}  // namespace dadrl
