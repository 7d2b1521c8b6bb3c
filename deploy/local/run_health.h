// What goes wrong in a running training: who is in trouble, what that costs, and the file from which a
// monitor that is started later knows it.
#pragma once

#include <filesystem>
#include <string>

#include "common/util/clock.h"
#include "common/util/fault.h"
#include "deploy/local/lost_time.h"
#include "deploy/local/stall_watch.h"
#include "deploy/local/supervisor.h"
#include "deploy/monitor/supervision.h"

namespace dadrl {

// Not thread safe. Writes `file` without waiting for the device.
class RunHealth {
 public:
  // Borrows both; `faults` is told whether the file can be written.
  RunHealth(std::filesystem::path file, const Clock& clock, FaultBoard& faults);

  // Looks at the processes, a few times a second however often it is called. While `training`, the time in
  // which they do not train counts as lost.
  void Step(const Supervisor& supervisor, bool training);
  // The run was kept stopped for so long.
  void AddPause(Duration paused);

  const Supervision& supervision() const { return supervision_; }
  const LostTime& lost() const { return lost_; }
  // What holds up the training now, one line; empty when nothing does.
  const std::string& fault() const { return fault_; }

 private:
  void Sum(const Supervisor& supervisor, TimePoint now);
  std::string StallOf(const Supervisor& supervisor, TimePoint now);

  const std::filesystem::path file_;
  const Clock& clock_;
  FaultBoard& faults_;
  TimePoint next_;
  Supervision supervision_;
  StallWatch stall_;
  LostTime lost_;
  std::string fault_;
};

}  // namespace dadrl
