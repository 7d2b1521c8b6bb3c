// A replay shard that does what a test tells it: takes chunks, stores them in order, acknowledges.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "common/dds/node.h"
#include "common/port/port.h"
#include "common/util/mutex.h"
#include "proto/experience.h"
#include "proto/topics.h"
#include "tests/actor/experience/lease_clerk.h"
#include "tests/common/io/test_run_key.h"
#include "tests/common/util/eventually.h"

namespace dadrl {

// What outlives a replay process: its disk. Stores each sequence of one actor incarnation exactly once, in
// order.
struct ReplayDisk {
  struct Stored {
    uint64_t sequence = 0;
    uint64_t episode = 0;
    uint32_t first_frame = 0;
    std::vector<float> rewards;
  };
  Mutex mutex;
  std::vector<Stored> chunks DADRL_GUARDED_BY(mutex);
  uint64_t duplicates DADRL_GUARDED_BY(mutex) = 0;

  uint64_t stored() {
    MutexLock lock(mutex);
    return chunks.size();
  }
  std::vector<Stored> Copy() {
    MutexLock lock(mutex);
    return chunks;
  }
};

class ReplayPeer {
 public:
  // Grants `window` sequences beyond what is stored; both may be changed while it runs. Gone, it is as a
  // process that was killed: nothing that was received but not taken is kept.
  ReplayPeer(const Transport& transport, ReplayDisk& disk, uint64_t window)
      : disk_(disk), window_(window), clerk_(transport) {
    chunks_ = Reader<dadrl_idl_ChunkMessage>::Create(transport, ChunkTopic(0)).value();
    for (uint32_t group = 0; group < kAcknowledgementGroups; ++group) {
      acknowledgements_[group] =
          Writer<dadrl_idl_Acknowledgement>::Create(transport, AcknowledgementTopic(group)).value();
    }
  }

  // Takes what is there, and answers. One thread at a time.
  void Step() {
    clerk_.Serve();
    chunks_->Take(16, [this](const dadrl_idl_ChunkMessage& message) { OnChunk(message); });
    if (incarnation_ != 0 && acknowledging_) Acknowledge();
  }
  void Wait() { chunks_->Wait(std::chrono::milliseconds(20)); }

  void set_window(uint64_t window) { window_ = window; }
  void set_acknowledging(bool on) { acknowledging_ = on; }
  // Lets this many chunks pass unseen, as if they had been lost.
  void LoseNext(int count) { lose_ = count; }
  uint64_t highest_seen() const { return highest_seen_; }
  uint32_t newest_policy_version() const { return newest_policy_version_; }
  // Of the frame that came last.
  uint32_t last_policy_version() const { return last_policy_version_; }
  void SendAcknowledgement(const dadrl_idl_Acknowledgement& ack) {
    EXPECT_TRUE(acknowledgements_[ack.actor % kAcknowledgementGroups]->Write(ack));
  }

 private:
  void OnChunk(const dadrl_idl_ChunkMessage& message) {
    const auto view =
        ChunkView::Parse({reinterpret_cast<const std::byte*>(message.bytes._buffer), message.bytes._length});
    ASSERT_TRUE(view) << view.error().message;
    const ChunkIdentity& identity = view->header().identity;
    if (identity.incarnation != incarnation_) NewIncarnation();
    highest_seen_ = std::max<uint64_t>(highest_seen_, identity.sequence);
    for (int frame = 0; frame < view->frames(); ++frame) {
      last_policy_version_ = view->policy_version(frame);
      newest_policy_version_ = std::max<uint32_t>(newest_policy_version_, last_policy_version_);
    }
    actor_ = identity.actor;
    incarnation_ = identity.incarnation;
    if (lose_ > 0) {
      --lose_;
      return;
    }
    Store(*view, message.oldest_kept);
  }
  // This peer knows one incarnation at a time.
  void NewIncarnation() {
    if (incarnation_ == 0) return;
    MutexLock lock(disk_.mutex);
    disk_.chunks.clear();
    highest_seen_ = 0;
  }
  void Store(const ChunkView& view, uint64_t oldest_kept) {
    MutexLock lock(disk_.mutex);
    const uint64_t sequence = view.header().identity.sequence;
    EXPECT_GE(oldest_kept, 1);
    EXPECT_LE(oldest_kept, sequence);
    EXPECT_LE(oldest_kept, disk_.chunks.size() + 1) << "the actor dropped what was not stored";
    if (sequence <= disk_.chunks.size()) ++disk_.duplicates;
    if (sequence != disk_.chunks.size() + 1) return;
    ReplayDisk::Stored stored{sequence, view.header().episode, view.header().first_frame, {}};
    for (int frame = 0; frame < view.frames(); ++frame) stored.rewards.push_back(view.reward(frame));
    disk_.chunks.push_back(std::move(stored));
  }
  void Acknowledge() {
    dadrl_idl_Acknowledgement ack{};
    ack.actor = actor_;
    ack.incarnation = incarnation_;
    ack.stored_sequence = disk_.stored();
    ack.granted_sequence = ack.stored_sequence + window_;
    SendAcknowledgement(ack);
  }

  ReplayDisk& disk_;
  std::atomic<uint64_t> window_;
  std::atomic<bool> acknowledging_{true};
  std::atomic<int> lose_{0};
  std::atomic<uint64_t> highest_seen_{0};
  std::atomic<uint32_t> newest_policy_version_{0};
  std::atomic<uint32_t> last_policy_version_{0};
  uint32_t actor_ = 0;
  uint64_t incarnation_ = 0;
  LeaseClerk clerk_;
  std::unique_ptr<Reader<dadrl_idl_ChunkMessage>> chunks_;
  std::array<std::unique_ptr<Writer<dadrl_idl_Acknowledgement>>, kAcknowledgementGroups> acknowledgements_;
};

// One over DDS, on a thread of its own.
class RunningReplayPeer {
 public:
  RunningReplayPeer(const ClusterConfig& cluster, ReplayDisk& disk, uint64_t window)
      : node_(dds::Node::Create(cluster, 1, dds::Role::kReplay, 0, kTestRunKey).value()),
        peer_(*node_, disk, window) {
    thread_ = std::thread([this] {
      while (!stopping_) {
        peer_.Step();
        peer_.Wait();
      }
    });
  }
  ~RunningReplayPeer() {
    stopping_ = true;
    thread_.join();
  }
  ReplayPeer* operator->() { return &peer_; }

 private:
  std::unique_ptr<dds::Node> node_;
  ReplayPeer peer_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace dadrl
