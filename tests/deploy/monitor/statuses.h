// Status messages for the monitor's tests.
#pragma once

#include "proto/telemetry.h"

namespace dadrl {

inline ProcessStatus MakeStatus(dds::Role role, int index, double uptime_s, uint64_t incarnation = 1) {
  ProcessStatus status;
  status.role = role;
  status.index = index;
  status.pid = 100 + index;
  status.incarnation = incarnation;
  status.uptime_s = uptime_s;
  return status;
}

}  // namespace dadrl
