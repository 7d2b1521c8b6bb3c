#include "learner/heartbeat.h"

#include "common/util/log.h"

namespace dadrl {

Result<std::unique_ptr<Heartbeat>> Heartbeat::Start(const dds::Node& node, uint64_t incarnation,
                                                    std::function<uint64_t()> progress,
                                                    Duration stuck_after) {
  DADRL_ASSIGN_OR_RETURN(auto writer, dds::Writer<dadrl_idl_Heartbeat>::Create(node, kHeartbeatTopic));
  return std::unique_ptr<Heartbeat>(new Heartbeat(std::move(writer), FromSeconds(node.liveliness_s() / 4),
                                                  incarnation, std::move(progress), stuck_after));
}

Heartbeat::Heartbeat(std::unique_ptr<dds::Writer<dadrl_idl_Heartbeat>> writer, Duration interval,
                     uint64_t incarnation, std::function<uint64_t()> progress, Duration stuck_after)
    : writer_(std::move(writer)),
      interval_(interval),
      incarnation_(incarnation),
      progress_(std::move(progress)),
      stuck_after_(stuck_after),
      thread_([this] { Run(); }) {}

Heartbeat::~Heartbeat() {
  {
    MutexLock lock(mutex_);
    stopping_ = true;
    changed_.NotifyAll();
  }
  thread_.join();
}

void Heartbeat::Run() {
  SystemClock clock;
  uint64_t seen = progress_();
  TimePoint seen_at = clock.Now();
  bool stuck = false;
  for (uint64_t beat = 1;; ++beat) {
    const uint64_t progress = progress_();
    if (progress != seen) {
      seen = progress;
      seen_at = clock.Now();
    }
    const bool is_stuck = clock.Now() - seen_at > stuck_after_;
    if (is_stuck && !stuck) spdlog::error("the training loop stands still: no more heartbeats");
    stuck = is_stuck;
    if (!stuck) {
      const dadrl_idl_Heartbeat sample{.role = static_cast<uint32_t>(dds::Role::kLearner),
                                       .index = 0,
                                       .incarnation = incarnation_,
                                       .beat = beat};
      const Status written = writer_->Write(sample);
      if (!written) spdlog::warn("heartbeat: {}", written.error().message);
    }
    MutexLock lock(mutex_);
    if (!stopping_) changed_.WaitFor(mutex_, interval_);
    if (stopping_) return;
  }
}

}  // namespace dadrl
