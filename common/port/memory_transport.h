// Ports within one process, with the semantics that a topic's QoS asks of DDS: what is tested on them, or run
// in lockstep, runs in the cluster.
#pragma once

#include <memory>

#include "common/port/port.h"
#include "common/util/clock.h"

namespace dadrl {

// All its ports see each other at once, and a sample that Write took can be taken when it returns. A sample
// is copied once, however many read it.
class MemoryTransport final : public Transport {
 public:
  // For threads: waits are real.
  MemoryTransport();
  // For one thread, which nobody else can wake: whoever would wait lets that time pass on `clock`, and goes
  // on.
  explicit MemoryTransport(ManualClock& clock);
  ~MemoryTransport() override;

  Result<std::unique_ptr<WriterPort>> OpenWriter(const TopicSpec& topic) const override;
  Result<std::unique_ptr<ReaderPort>> OpenReader(const TopicSpec& topic) const override;

 private:
  class Medium;
  class MemoryWriter;
  class MemoryReader;
  const std::unique_ptr<Medium> medium_;
};

}  // namespace dadrl
