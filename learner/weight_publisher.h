// Broadcasts policies to the actors.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "common/dds/node.h"
#include "common/port/port.h"
#include "common/util/background_thread.h"
#include "common/util/clock.h"
#include "common/util/mutex.h"
#include "common/util/result.h"
#include "learner/policy_publisher.h"
#include "learner/version_reserve.h"
#include "proto/topics.h"

namespace dadrl {

// What is slow, writing to actors and to the version reserve, is done by Step, once started on a thread of
// its own, which alone calls it then. Late actors get the newest policy from the middleware. Publish: one
// thread; the rest: any.
class WeightPublisher final : public PolicyPublisher {
 public:
  // `newest_version`: of the run so far, 0 for a new one. Borrows `clock`, which stamps what is sent.
  static Result<std::unique_ptr<WeightPublisher>> Create(const Transport& transport, VersionReserve reserve,
                                                         uint32_t newest_version, const Clock& clock);
  // Sends what was published last, then ends.
  ~WeightPublisher() override;

  void Publish(const PolicyUpdate& update) override DADRL_EXCLUDES(mutex_);
  // Steps on a thread of its own from now on.
  void Start();
  // Sends what was published last, unless it was sent before.
  void Step() DADRL_EXCLUDES(mutex_);

  uint32_t newest_version() const { return newest_version_.load(std::memory_order_relaxed); }

 private:
  struct Pending {
    uint32_t version = 0;  // 0: nothing
    uint64_t layout_hash = 0;
    std::vector<float> parameters;
  };

  WeightPublisher(std::unique_ptr<Writer<dadrl_idl_Weights>> writer, VersionReserve reserve,
                  uint32_t newest_version, const Clock& clock);
  void Send(const Pending& policy);

  std::unique_ptr<Writer<dadrl_idl_Weights>> writer_;
  VersionReserve reserve_;  // Step's
  const Clock& clock_;
  Pending sending_;  // Step's; takes turns with `pending_`
  Mutex mutex_;
  Pending pending_ DADRL_GUARDED_BY(mutex_);
  std::atomic<uint32_t> newest_version_;
  std::optional<BackgroundThread> thread_;
};

}  // namespace dadrl
