#include "learner/priority_sender.h"

#include <algorithm>

#include "proto/borrowed_sequence.h"

namespace dadrl {

Result<std::unique_ptr<PrioritySender>> PrioritySender::Create(const Transport& transport,
                                                               uint64_t incarnation, double most) {
  DADRL_ASSIGN_OR_RETURN(auto writer, Writer<dadrl_idl_PriorityUpdate>::Create(transport, kPriorityTopic));
  return std::unique_ptr<PrioritySender>(new PrioritySender(std::move(writer), incarnation, most));
}

PrioritySender::PrioritySender(std::unique_ptr<Writer<dadrl_idl_PriorityUpdate>> writer, uint64_t incarnation,
                               double most)
    : writer_(std::move(writer)),
      incarnation_(incarnation),
      most_(static_cast<float>(most)),
      messages_(kMessages) {
  for (Message& message : messages_) free_.PushOrDrop(&message);  // has room for all
}

void PrioritySender::Start() {
  thread_.emplace([this](bool last) {
    if (!last) Step();
    return BackgroundThread::kUntilWoken;
  });
}

void PrioritySender::Send(uint32_t shard, std::span<const uint64_t> keys, std::span<const float> priorities) {
  const std::optional<Message*> message = free_.Pop(Duration::zero());
  if (!message) {
    dropped_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  (*message)->shard = shard;
  (*message)->keys.assign(keys.begin(), keys.end());
  std::vector<float>& bounded = (*message)->priorities;
  bounded.assign(priorities.begin(), priorities.end());
  for (float& priority : bounded) priority = std::min(priority, most_);
  filled_.PushOrDrop(*message);  // has room for all
  if (thread_) thread_->Wake();
}

void PrioritySender::Step() {
  while (const std::optional<Message*> next = filled_.Pop(Duration::zero())) {
    Write(**next);
    free_.PushOrDrop(*next);  // has room for all
  }
}

void PrioritySender::Write(const Message& message) {
  dadrl_idl_PriorityUpdate sample{};
  sample.shard = message.shard;
  sample.learner = incarnation_;
  Borrow(message.keys, sample.keys);
  Borrow(message.priorities, sample.priorities);
  if (!writer_->Write(sample)) dropped_.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace dadrl
