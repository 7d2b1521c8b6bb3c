#include "learner/weight_publisher.h"

#include "common/io/checksum.h"
#include "common/util/fault.h"
#include "common/util/log.h"
#include "proto/borrowed_sequence.h"

namespace dadrl {

Result<std::unique_ptr<WeightPublisher>> WeightPublisher::Create(const Transport& transport,
                                                                 VersionReserve reserve,
                                                                 uint32_t newest_version,
                                                                 const Clock& clock) {
  DADRL_ASSIGN_OR_RETURN(auto writer, Writer<dadrl_idl_Weights>::Create(transport, kWeightsTopic));
  return std::unique_ptr<WeightPublisher>(
      new WeightPublisher(std::move(writer), std::move(reserve), newest_version, clock));
}

WeightPublisher::WeightPublisher(std::unique_ptr<Writer<dadrl_idl_Weights>> writer, VersionReserve reserve,
                                 uint32_t newest_version, const Clock& clock)
    : writer_(std::move(writer)),
      reserve_(std::move(reserve)),
      clock_(clock),
      newest_version_(newest_version) {}

WeightPublisher::~WeightPublisher() {
  thread_.reset();
  Step();
}

void WeightPublisher::Start() {
  thread_.emplace([this](bool) {
    Step();
    return BackgroundThread::kUntilWoken;
  });
}

void WeightPublisher::Publish(const PolicyUpdate& update) {
  newest_version_.store(update.version, std::memory_order_relaxed);
  {
    MutexLock lock(mutex_);
    pending_.version = update.version;
    pending_.layout_hash = update.layout_hash;
    pending_.parameters.assign(update.parameters.begin(), update.parameters.end());
  }
  if (thread_) thread_->Wake();
}

void WeightPublisher::Step() {
  {
    MutexLock lock(mutex_);
    if (pending_.version == 0) return;
    std::swap(sending_, pending_);
    pending_.version = 0;
  }
  Send(sending_);
}

void WeightPublisher::Send(const Pending& policy) {
  // A version that cannot be reserved (a medium that takes no writes) stays here: after a crash the same
  // number would stand for other weights, and actors would not take them. The next policy tries again.
  const Status reserved = reserve_.Use(policy.version);
  ProcessFaults().Report(FaultKind::kWeights, reserved);
  if (!reserved) return;
  const std::span<const std::byte> bytes = std::as_bytes(std::span(policy.parameters));
  dadrl_idl_Weights sample{};
  sample.version = policy.version;
  sample.published_ns = clock_.WallTimeNs();
  sample.layout_hash = policy.layout_hash;
  sample.checksum = Xxh3(bytes);
  Borrow(bytes, sample.parameters);
  const Status written = writer_->Write(sample);
  if (!written) spdlog::warn("weights version {} was not sent: {}", policy.version, written.error().message);
}

}  // namespace dadrl
