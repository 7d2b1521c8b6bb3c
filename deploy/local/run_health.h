// What goes wrong in a running training: who is in trouble, what that costs, and the file from which a
// monitor that is started later knows it.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "common/util/clock.h"
#include "deploy/local/lost_time.h"
#include "deploy/local/stall_watch.h"
#include "deploy/local/supervisor.h"
#include "deploy/monitor/supervision.h"

namespace dadrl {

// Not thread safe. Writes `file` without waiting for the device.
class RunHealth {
 public:
  // Borrows `clock`; `message` is told, once, that the file cannot be written.
  RunHealth(std::filesystem::path file, const Clock& clock, std::function<void(const std::string&)> message);

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
  void Save();

  const std::filesystem::path file_;
  const Clock& clock_;
  const std::function<void(const std::string&)> message_;
  TimePoint next_;
  Supervision supervision_;
  StallWatch stall_;
  LostTime lost_;
  std::string fault_;
  bool save_failed_ = false;
};

}  // namespace dadrl
