// What every ProcessStatus says whoever sends it: who, since when, how its time goes and what fails now.
#pragma once

#include <cstdint>

#include "common/util/clock.h"
#include "common/util/time_ledger.h"
#include "proto/telemetry.h"

namespace dadrl {

// Thread safe. Borrows clock and ledger.
class StatusEnvelope {
 public:
  struct Sender {
    dds::Role role = dds::Role::kActor;
    int index = 0;
    uint64_t incarnation = 0;
  };
  // `ledger`: of the process's main loop. `started`: when its uptime began.
  StatusEnvelope(const Sender& sender, const Clock& clock, const TimeLedger& ledger, TimePoint started)
      : sender_(sender), clock_(clock), ledger_(ledger), started_(started) {}

  // A status of this moment, without metrics and scalars.
  ProcessStatus Begin() const;

 private:
  const Sender sender_;
  const Clock& clock_;
  const TimeLedger& ledger_;
  const TimePoint started_;
};

}  // namespace dadrl
