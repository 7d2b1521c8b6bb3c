// What the launcher knows of the processes it supervises, for people: on its own panel, and through a file of
// the run directory for a monitor that is started later and may never have heard of them.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

#include "common/util/result.h"

namespace dadrl {

// One process.
struct SupervisedProcess {
  std::string name;   // "replay-0"
  pid_t pid = 0;      // 0: it does not run
  std::string state;  // "starting", "running", "restarting", "stopping", "ended", "given up"
  // Why it does not do its work ("silent for 3 s: stopped by a signal", "starts again after signal 9"), or
  // what holds it up ("cannot store experience: disk full"); empty when it does.
  std::string trouble;
  // The same without figures, for sums; empty when the others can do without it.
  std::string fault;
  int restarts = 0;
  int hangs = 0;         // restarts because it hung
  std::string last_end;  // why it was last restarted: "hung: it is stopped by a signal"
  int64_t since_ns = 0;  // wall time of its last start or end

  bool operator==(const SupervisedProcess&) const = default;
};

struct Supervision {
  pid_t launcher = 0;
  std::vector<SupervisedProcess> processes;

  bool operator==(const Supervision&) const = default;
  // A line for each process in trouble: "replay-0: silent for 3 s: stopped by a signal".
  std::vector<std::string> Troubles() const;
  const SupervisedProcess* Find(const std::string& name) const;
};

std::string SupervisionJson(const Supervision& supervision);
// kCorrupt: it is none.
Result<Supervision> ParseSupervision(const std::string& text);

// Replaces the file at once, without waiting for the device: what it says is true only while the launcher
// runs. After an error there is none, where possible: an old one would name processes that are gone.
Status SaveSupervision(const std::filesystem::path& file, const Supervision& supervision);
Result<Supervision> LoadSupervision(const std::filesystem::path& file);

// Adds what only the system knows now: that the launcher, or a process, is stopped by a signal.
void AddStopped(Supervision& supervision, const std::filesystem::path& proc = "/proc");

}  // namespace dadrl
