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

inline double& Seconds(ProcessStatus& status, Activity activity) {
  return status.activity_s[static_cast<size_t>(activity)];
}

}  // namespace dadrl
