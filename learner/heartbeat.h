// Tells the cluster that the training loop lives.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>

#include "common/dds/endpoint.h"
#include "common/dds/node.h"
#include "common/util/clock.h"
#include "common/util/mutex.h"
#include "common/util/result.h"
#include "proto/topics.h"

namespace dadrl {

// Owns a thread that writes a beat four times in each liveliness period, as long as `progress` has changed
// within the last ten seconds: one update on a slow machine may take longer than the liveliness period, a
// loop that stands still for ten seconds is stuck.
class Heartbeat {
 public:
  // `progress` is called on the heartbeat's thread.
  static Result<std::unique_ptr<Heartbeat>> Start(const dds::Node& node, uint64_t incarnation,
                                                  std::function<uint64_t()> progress,
                                                  Duration stuck_after = std::chrono::seconds(10));
  ~Heartbeat();

 private:
  Heartbeat(std::unique_ptr<dds::Writer<dadrl_idl_Heartbeat>> writer, Duration interval, uint64_t incarnation,
            std::function<uint64_t()> progress, Duration stuck_after);
  void Run();

  const std::unique_ptr<dds::Writer<dadrl_idl_Heartbeat>> writer_;
  const Duration interval_;
  const uint64_t incarnation_;
  const std::function<uint64_t()> progress_;
  const Duration stuck_after_;
  Mutex mutex_;
  CondVar changed_;
  bool stopping_ DADRL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace dadrl
