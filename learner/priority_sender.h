// Priorities back to the replay shards, without the training thread waiting for the network.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/dds/node.h"
#include "common/port/port.h"
#include "common/util/background_thread.h"
#include "common/util/bounded_queue.h"
#include "common/util/result.h"
#include "proto/topics.h"

namespace dadrl {

// Owns a few buffers that it reuses, and once started a thread, which alone steps then. Send: one thread. A
// priority above `most`, which no replay believes (ExperienceBounds), is sent as that.
class PrioritySender {
 public:
  static Result<std::unique_ptr<PrioritySender>> Create(const Transport& transport, uint64_t incarnation,
                                                        double most);

  // Steps on a thread of its own from now on.
  void Start();
  // Writes what was given to Send.
  void Step();

  // Copies both; `keys` and `priorities` are equally long. Dropped and counted when the sender is behind:
  // stale priorities are not worth waiting for.
  void Send(uint32_t shard, std::span<const uint64_t> keys, std::span<const float> priorities);

  uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

 private:
  struct Message {
    uint32_t shard = 0;
    std::vector<uint64_t> keys;
    std::vector<float> priorities;
  };
  static constexpr size_t kMessages = 8;

  void Write(const Message& message);
  PrioritySender(std::unique_ptr<Writer<dadrl_idl_PriorityUpdate>> writer, uint64_t incarnation, double most);

  std::unique_ptr<Writer<dadrl_idl_PriorityUpdate>> writer_;
  const uint64_t incarnation_;  // of the learner
  const float most_;
  std::vector<Message> messages_;
  BoundedQueue<Message*> free_{kMessages};
  BoundedQueue<Message*> filled_{kMessages};
  std::atomic<uint64_t> dropped_{0};
  std::optional<BackgroundThread> thread_;
};

}  // namespace dadrl
