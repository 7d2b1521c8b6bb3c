// Priorities back to the replay shards, without the training thread waiting for the network.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <thread>
#include <vector>

#include "common/dds/endpoint.h"
#include "common/dds/node.h"
#include "common/util/bounded_queue.h"
#include "common/util/result.h"
#include "proto/topics.h"

namespace dadrl {

// Owns its thread and a few buffers that it reuses. Send: one thread. A priority above `most`, which no
// replay believes (ExperienceBounds), is sent as that.
class PrioritySender {
 public:
  static Result<std::unique_ptr<PrioritySender>> Create(const dds::Node& node, uint64_t incarnation,
                                                        double most);
  ~PrioritySender();

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

  PrioritySender(std::unique_ptr<dds::Writer<dadrl_idl_PriorityUpdate>> writer, uint64_t incarnation,
                 double most);
  void Run();

  std::unique_ptr<dds::Writer<dadrl_idl_PriorityUpdate>> writer_;
  const uint64_t incarnation_;  // of the learner
  const float most_;
  std::vector<Message> messages_;
  BoundedQueue<Message*> free_{kMessages};
  BoundedQueue<Message*> filled_{kMessages};
  std::atomic<uint64_t> dropped_{0};
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace dadrl
