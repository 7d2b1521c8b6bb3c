#include "proto/status_envelope.h"

#include <unistd.h>

namespace dadrl {

ProcessStatus StatusEnvelope::Begin() const {
  ProcessStatus status;
  status.role = sender_.role;
  status.index = sender_.index;
  status.pid = ::getpid();
  status.incarnation = sender_.incarnation;
  status.sent_ns = clock_.WallTimeNs();
  status.uptime_s = ToSeconds(clock_.Now() - started_);
  status.activities = ledger_.Read();
  status.faults = ProcessFaults().Current();
  return status;
}

}  // namespace dadrl
