// What a cluster does now, from the status messages of its processes: rates, ages, waits. Pure: no telemetry
// and no clock in here.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/util/clock.h"
#include "common/util/enum_array.h"
#include "proto/telemetry.h"

namespace dadrl {

// What a process waits for ("inserts", "batch", ...).
struct Wait {
  std::string who;
  std::string for_what;
  double fraction = 0.0;  // of its time over the window, 0 to 1
  TimeSpent spent;        // since the process started
};

// A fault of a process, as it says itself.
struct ProcessFault {
  std::string process;  // "replay-0"
  Fault fault;
  bool operator==(const ProcessFault&) const = default;
};

struct MeanMax {
  double mean = 0.0;
  double max = 0.0;
};

// One process as last heard of.
struct ProcessRow {
  std::string name;  // "learner", "replay-0", "actor-3"
  dds::Role role = dds::Role::kActor;
  int index = 0;
  int pid = 0;
  double uptime_s = 0.0;
  double silent_s = 0.0;  // since its last message
  bool stale = false;     // silent for too long: dead, cut off or stuck
  int restarts = 0;       // incarnations seen after the first
  // As its launcher sees it (supervision.h), where that is known.
  std::string state;
  std::string trouble;
  int hangs = 0;
  double steps_per_s = 0.0;             // of what it produces: environment steps, inserted frames, updates
  EnumArray<Activity, double> share{};  // of its time, over the window
  ActivityTotals activities;            // since it started
  EnumArray<Metric, double> metrics{};
  std::vector<Fault> faults;
  std::vector<NamedScalar> scalars;  // of the last message that had any

  double operator[](Metric metric) const { return metrics[metric]; }
  double Share(Activity activity) const { return share[activity]; }
};

struct RecentRate {
  int episodes = 0;
  double success = 0.0;
};

struct ClusterSummary {
  std::vector<ProcessRow> processes;  // learner, replays, actors; each by index
  int actors_alive = 0;
  double env_steps_per_s = 0.0;
  double inserted_frames_per_s = 0.0;
  double sampled_transitions_per_s = 0.0;
  double inserted_mb_per_s = 0.0;  // 1e6 bytes
  double sampled_mb_per_s = 0.0;
  double updates_per_s = 0.0;
  // Since the view began, over restarts.
  double env_steps = 0.0;
  double episodes = 0.0;
  double updates = 0.0;        // as the learner counts them: over the whole run
  double learner_cpu_s = 0.0;  // the same, processor time
  double weights_version = 0.0;
  double replay_frames = 0.0;
  double replay_bytes = 0.0;
  double snapshot_bytes = 0.0;  // held by snapshots alone
  MeanMax staleness_versions;
  MeanMax staleness_s;
  // What was refused or dropped since the view began, by kind ("garbage", "duplicate chunks"); only what
  // happened.
  std::map<std::string, double> rejected;
  std::vector<ProcessFault> faults;  // that last now, those that hold up training first
  std::vector<NamedScalar> scalars;  // the learner's, as its algorithm orders them
  std::vector<Wait> waits;           // all that ever began; those that take most of the window first
  // Of the last (up to) 100 training episodes.
  int recent_episodes = 0;
  double recent_success = 0.0;
  double recent_collision = 0.0;
  double recent_off_road = 0.0;
  double recent_stagnation = 0.0;
  double recent_return = 0.0;
  std::map<std::string, RecentRate> recent_scenarios;  // the same episodes by scenario
};

std::string RoleName(dds::Role role);

// Not thread safe. Holds a bounded amount whatever it is told: anyone on this host can forge a status.
class ClusterView {
 public:
  // Rates are means over `window`; a process silent for `stale_after` counts as not running.
  ClusterView(Duration window, Duration stale_after) : window_(window), stale_after_(stale_after) {}
  // Window and limit that suit messages every `interval_s`.
  static ClusterView ForInterval(double interval_s);

  // False when it was not taken: one process more than a cluster can have.
  bool Add(const ProcessStatus& status, TimePoint received);
  void Add(const EpisodeReport& report);

  ClusterSummary Summarize(TimePoint now) const;
  // Processes that have not gone stale and whose rates are known (two messages of one incarnation).
  int ReportingProcesses(TimePoint now) const;

 private:
  struct Process {
    std::deque<ProcessStatus> history;  // of the current incarnation, oldest first; without scalars
    std::vector<NamedScalar> scalars;   // the last there were: an interval without an update has none
    TimePoint received{};
    int restarts = 0;
    // Counters of earlier incarnations, last heard values.
    EnumArray<Metric, double> before{};
  };
  using Key = std::pair<dds::Role, int>;

  // Makes room for one process more where there is none: those that are silent go.
  bool MakeRoom(TimePoint now);

  // Adds one process's part to the sums.
  void Accumulate(const ProcessRow& row, const Process& process, TimePoint now,
                  ClusterSummary& summary) const;
  ProcessRow Row(const Key& key, const Process& process, TimePoint now) const;
  // Mean growth a second of a cumulative counter; 0 when stale or unknown.
  double Rate(const Process& process, Metric metric, TimePoint now) const;
  double Total(dds::Role role, Metric metric) const;
  bool Stale(const Process& process, TimePoint now) const;

  Duration window_;
  Duration stale_after_;
  std::map<Key, Process> processes_;
  TimePoint room_at_{};  // while there is no room: when the next one may count as silent
  std::deque<EpisodeReport> episodes_;
};

}  // namespace dadrl
