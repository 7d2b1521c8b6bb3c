// A disk on which a forced write takes for ever: inserts wait, samples do not. The replay's two sides in this
// process, over real DDS.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "common/dds/node.h"
#include "replay/service/batch_server.h"
#include "replay/service/ingest.h"
#include "tests/replay/service/peers.h"

namespace dadrl {
namespace {

class GatedDisk {
 public:
  Segment::Force Force() {
    return [this](const FileDescriptor& file, const std::filesystem::path& path) -> Status {
      MutexLock lock(mutex_);
      while (closed_) {
        waiting_ = true;
        changed_.WaitFor(mutex_, std::chrono::seconds(1));
      }
      return SyncFile(file, path);
    };
  }
  void Close(bool closed) {
    MutexLock lock(mutex_);
    closed_ = closed;
    changed_.NotifyAll();
  }
  bool waiting() const { return waiting_; }

 private:
  Mutex mutex_;
  CondVar changed_;
  bool closed_ DADRL_GUARDED_BY(mutex_) = false;
  std::atomic<bool> waiting_{false};
};

class SlowDisk : public testing::Test {
 protected:
  static constexpr int kActors = 4;

  SlowDisk() {
    config_.replay.sync = SyncMode::kAlways;
    config_.replay.min_size = 4;
    config_.replay.samples_per_insert = 0.0;
    config_.algorithm.n_step = 1;
    config_.cluster.port = dds::FindFreePort().value();
    table_ = ReplayTable::Open({.directory = folder_.path(),
                                .spec = kTestSpec,
                                .replay = config_.replay,
                                .force = disk_.Force()},
                               clock_)
                 .value();
    node_ = dds::Node::Create(config_.cluster, 1, dds::Role::kReplay, 0).value();
    server_ = BatchServer::Create(*node_, 0, *table_, clock_, [] {}).value();
    ingest_ = Ingest::Create(*node_, config_, 0, *table_, clock_, [] {}).value();
    ingesting_ = std::thread([this] { ingest_->Run(stop_); });
    serving_ = std::thread([this] { server_->Run(stop_); });
    actor_node_ = dds::Node::Create(config_.cluster, 1, dds::Role::kActor, 0).value();
    learner_node_ = dds::Node::Create(config_.cluster, 1, dds::Role::kLearner, 0).value();
    learner_ = std::make_unique<PeerLearner>(*learner_node_, 200, 1);
    for (uint32_t id = 0; id < kActors; ++id) {
      actors_.push_back(std::make_unique<PeerActor>(*actor_node_, id, 100));
      for (uint64_t i = 1; i <= 400; ++i) actors_.back()->Add({.episode = i, .end = kTerminated});
    }
  }
  ~SlowDisk() override {
    disk_.Close(false);
    stop_ = true;
    for (std::thread* thread : {&pumping_, &ingesting_, &serving_}) {
      if (thread->joinable()) thread->join();
    }
  }
  // All actors send what they may, from now on.
  void Pump() {
    pumping_ = std::thread([this] {
      while (!stop_) {
        uint64_t stored = 0;
        uint64_t refused = 0;
        for (const auto& actor : actors_) {
          actor->Pump();
          stored += actor->stored();
          refused += actor->refused_writes();
        }
        stored_ = stored;
        refused_writes_ = refused;
      }
    });
  }

  MemoryFolder folder_;
  Config config_;
  SystemClock clock_;
  GatedDisk disk_;
  std::unique_ptr<ReplayTable> table_;
  std::unique_ptr<dds::Node> node_;
  std::unique_ptr<BatchServer> server_;
  std::unique_ptr<Ingest> ingest_;
  std::unique_ptr<dds::Node> actor_node_;
  std::unique_ptr<dds::Node> learner_node_;
  std::unique_ptr<PeerLearner> learner_;
  std::vector<std::unique_ptr<PeerActor>> actors_;
  std::atomic<uint64_t> stored_{0};
  std::atomic<uint64_t> refused_writes_{0};
  std::atomic<bool> stop_{false};
  std::thread ingesting_;
  std::thread serving_;
  std::thread pumping_;
};

TEST_F(SlowDisk, HoldsUpInsertsAndNotSamples) {
  Pump();
  ASSERT_TRUE(Eventually([&] { return stored_ > 20 * kActors; }));
  disk_.Close(true);
  // Until the chunk reader is full: nobody can send to it any more.
  ASSERT_TRUE(Eventually([&] { return disk_.waiting() && refused_writes_ > 0; }));
  const uint64_t stored = stored_;
  for (int i = 0; i < 100; ++i) ASSERT_FALSE(learner_->Fetch(64).bytes.empty()) << "batch " << i;
  EXPECT_EQ(stored_, stored) << "the disk was slow all the while";
  disk_.Close(false);
  EXPECT_TRUE(Eventually([&] { return stored_ == 400 * kActors; }));
}

TEST_F(SlowDisk, ActorsShareWhatTheReaderHolds) {
  EXPECT_TRUE(Eventually([&] {
    bool shared = true;
    for (const auto& actor : actors_) {
      actor->Pump();
      shared = shared && actor->granted() == actor->stored() + kChunkReaderSamples / kActors;
    }
    return shared;
  }));
}

}  // namespace
}  // namespace dadrl
