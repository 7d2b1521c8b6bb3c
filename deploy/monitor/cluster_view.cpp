#include "deploy/monitor/cluster_view.h"

#include <algorithm>

#include "proto/evaluation/episode_summary.h"

namespace dadrl {
namespace {

constexpr size_t kRecentEpisodes = 100;
// More than the largest cluster has; a status is less than a kilobyte, its scalars less than two.
constexpr size_t kMaxProcesses = 8192;
// Messages of one process in a window, at the shortest interval, and a few more.
constexpr size_t kMaxHistory = 256;
constexpr double kBytesPerMb = 1e6;
// Between two messages, whatever they say.
constexpr double kShortest_s = 1e-3;

struct RejectionKind {
  dds::Role role;
  Metric metric;
  const char* name;
};
constexpr RejectionKind kRejectionKinds[] = {
    {dds::Role::kReplay, Metric::kRejectedGarbage, "garbage"},
    {dds::Role::kReplay, Metric::kRejectedVersion, "other format version"},
    {dds::Role::kReplay, Metric::kRejectedLength, "wrong length"},
    {dds::Role::kReplay, Metric::kRejectedChecksum, "wrong checksum"},
    {dds::Role::kReplay, Metric::kRejectedContents, "impossible contents"},
    {dds::Role::kReplay, Metric::kRejectedSchema, "other observations"},
    {dds::Role::kReplay, Metric::kRejectedStale, "replaced actor"},
    {dds::Role::kActor, Metric::kRefusedChunks, "dropped by their actors"},
    {dds::Role::kReplay, Metric::kDuplicateChunks, "duplicate"},
    {dds::Role::kReplay, Metric::kLostChunks, "lost"},
    {dds::Role::kReplay, Metric::kRefusedRequests, "refused request"},
    {dds::Role::kReplay, Metric::kRefusedPriorities, "impossible priority"},
    {dds::Role::kLearner, Metric::kCorruptBatches, "corrupt batch"},
};

Metric ProductOf(dds::Role role) {
  switch (role) {
    case dds::Role::kReplay:
      return Metric::kInsertedFrames;
    case dds::Role::kLearner:
      return Metric::kUpdates;
    default:
      return Metric::kEnvSteps;
  }
}

// Learner first, then what feeds it.
int DisplayOrder(dds::Role role) {
  switch (role) {
    case dds::Role::kLearner:
      return 0;
    case dds::Role::kReplay:
      return 1;
    case dds::Role::kActor:
      return 2;
    default:
      return 3;
  }
}

EnumArray<Activity, double> Shares(const ActivityTotals& first, const ActivityTotals& last) {
  EnumArray<Activity, double> shares{};
  double sum = 0.0;
  for (size_t i = 0; i < shares.size(); ++i) {
    shares[i] = std::max(0.0, last[i].seconds - first[i].seconds);
    sum += shares[i];
  }
  for (double& share : shares) share = sum > 0.0 ? share / sum : 0.0;
  return shares;
}

void AppendWaits(const ProcessRow& row, std::vector<Wait>& waits) {
  if (row.stale) return;
  for (size_t i = 0; i < row.share.size(); ++i) {
    const Activity activity = row.share.At(i);
    const TimeSpent& spent = row.activities[activity];
    if (activity == Activity::kWork || spent.count == 0) continue;
    waits.push_back({row.name, std::string(ActivityName(activity)), row.share[activity], spent});
  }
}

void AppendFaults(const ProcessRow& row, std::vector<ProcessFault>& faults) {
  if (row.stale) return;
  for (const Fault& fault : row.faults) faults.push_back({row.name, fault});
}

void AddLearner(const ProcessRow& row, ClusterSummary& summary) {
  summary.updates = row[Metric::kUpdates];
  summary.learner_cpu_s = row[Metric::kLearnerCpuS];
  summary.weights_version = row[Metric::kWeightsVersion];
  summary.staleness_versions = {row[Metric::kStalenessVersionsMean], row[Metric::kStalenessVersionsMax]};
  summary.staleness_s = {row[Metric::kStalenessSecondsMean], row[Metric::kStalenessSecondsMax]};
  summary.scalars = row.scalars;
}

void AddRecentEpisodes(const std::deque<EpisodeReport>& episodes, ClusterSummary& summary) {
  if (episodes.empty()) return;
  std::array<double*, 4> rates = {&summary.recent_success, &summary.recent_collision,
                                  &summary.recent_off_road, &summary.recent_stagnation};
  const double part = 1.0 / episodes.size();
  summary.recent_episodes = std::ssize(episodes);
  for (const EpisodeReport& report : episodes) {
    *rates[static_cast<size_t>(report.outcome)] += part;
    summary.recent_return += part * report.episode_return;
    RecentRate& rate = summary.recent_scenarios[report.scenario];
    ++rate.episodes;
    if (report.outcome == static_cast<int>(Outcome::kSuccess)) rate.success += 1.0;
  }
  for (auto& [name, rate] : summary.recent_scenarios) rate.success /= rate.episodes;
}

}  // namespace

std::string RoleName(dds::Role role) {
  switch (role) {
    case dds::Role::kReplay:
      return "replay";
    case dds::Role::kLearner:
      return "learner";
    case dds::Role::kActor:
      return "actor";
    case dds::Role::kMonitor:
      return "monitor";
  }
  return "unknown";
}

ClusterView ClusterView::ForInterval(double interval_s) {
  return {FromSeconds(std::max(10.0, 5.0 * interval_s)), FromSeconds(std::max(3.0, 3.5 * interval_s))};
}

bool ClusterView::MakeRoom(TimePoint now) {
  if (processes_.size() < kMaxProcesses) return true;
  if (now <= room_at_) return false;  // a flood does not make us look at all of them each time
  std::erase_if(processes_, [&](const auto& entry) { return Stale(entry.second, now); });
  if (processes_.size() < kMaxProcesses) return true;
  const auto oldest =
      std::min_element(processes_.begin(), processes_.end(),
                       [](const auto& x, const auto& y) { return x.second.received < y.second.received; });
  room_at_ = oldest->second.received + stale_after_;
  return false;
}

bool ClusterView::Add(const ProcessStatus& status, TimePoint received) {
  if (!processes_.contains({status.role, status.index}) && !MakeRoom(received)) return false;
  const auto [found, is_new] = processes_.try_emplace(Key{status.role, status.index});
  Process& process = found->second;
  if (!is_new) {
    const ProcessStatus& last = process.history.back();
    if (status.incarnation < last.incarnation) return true;  // the late word of a dead predecessor
    if (status.incarnation > last.incarnation) {
      for (size_t i = 0; i < process.before.size(); ++i) process.before[i] += last.metrics[i];
      ++process.restarts;
      process.history.clear();
    } else if (status.uptime_s <= last.uptime_s) {
      return true;  // out of order
    }
  }
  process.received = received;
  process.history.push_back(status);
  if (!status.scalars.empty()) process.scalars = std::move(process.history.back().scalars);
  // Keeps one message at or before the window's start, so that the window is always covered.
  const double window_start_s = status.uptime_s - ToSeconds(window_);
  while (process.history.size() > 2 && process.history[1].uptime_s <= window_start_s) {
    process.history.pop_front();
  }
  if (process.history.size() > kMaxHistory) process.history.pop_front();
  return true;
}

void ClusterView::Add(const EpisodeReport& report) {
  if (report.outcome < 0 || report.outcome > 3) return;
  episodes_.push_back(report);
  if (episodes_.size() > kRecentEpisodes) episodes_.pop_front();
}

bool ClusterView::Stale(const Process& process, TimePoint now) const {
  return now - process.received > stale_after_;
}

double ClusterView::Rate(const Process& process, Metric metric, TimePoint now) const {
  if (process.history.size() < 2 || Stale(process, now)) return 0.0;
  const ProcessStatus& first = process.history.front();
  const ProcessStatus& last = process.history.back();
  // The sender's own uptime is the time base: monotonic, and free of the network's delay.
  const double elapsed_s = std::max(last.uptime_s - first.uptime_s, kShortest_s);
  return std::max(0.0, last[metric] - first[metric]) / elapsed_s;
}

double ClusterView::Total(dds::Role role, Metric metric) const {
  double total = 0.0;
  for (const auto& [key, process] : processes_) {
    if (key.first != role) continue;
    total += process.before[metric] + process.history.back()[metric];
  }
  return total;
}

ProcessRow ClusterView::Row(const Key& key, const Process& process, TimePoint now) const {
  const ProcessStatus& last = process.history.back();
  ProcessRow row;
  row.role = key.first;
  row.index = key.second;
  row.name = key.first == dds::Role::kLearner ? RoleName(key.first)
                                              : fmt::format("{}-{}", RoleName(key.first), key.second);
  row.pid = last.pid;
  row.uptime_s = last.uptime_s;
  row.silent_s = ToSeconds(now - process.received);
  row.stale = Stale(process, now);
  row.restarts = process.restarts;
  row.steps_per_s = Rate(process, ProductOf(key.first), now);
  row.metrics = last.metrics;
  row.scalars = process.scalars;
  // A single message has no earlier one to subtract: its totals since the start.
  row.share = Shares(process.history.size() > 1 ? process.history.front().activities : ActivityTotals{},
                     last.activities);
  row.activities = last.activities;
  row.faults = last.faults;
  return row;
}

void ClusterView::Accumulate(const ProcessRow& row, const Process& process, TimePoint now,
                             ClusterSummary& summary) const {
  const auto rate = [&](Metric metric) { return Rate(process, metric, now); };
  switch (row.role) {
    case dds::Role::kActor:
      summary.actors_alive += row.stale ? 0 : 1;
      summary.env_steps_per_s += rate(Metric::kEnvSteps);
      break;
    case dds::Role::kReplay:
      summary.inserted_frames_per_s += rate(Metric::kInsertedFrames);
      summary.sampled_transitions_per_s += rate(Metric::kSampledTransitions);
      summary.inserted_mb_per_s += rate(Metric::kInsertedBytes) / kBytesPerMb;
      summary.sampled_mb_per_s += rate(Metric::kSampledBytes) / kBytesPerMb;
      summary.replay_frames += row[Metric::kFramesHeld];
      summary.replay_bytes += row[Metric::kMemoryBytes];
      summary.snapshot_bytes += row[Metric::kSnapshotBytes];
      break;
    case dds::Role::kLearner:
      summary.updates_per_s += rate(Metric::kUpdates);
      AddLearner(row, summary);
      break;
    case dds::Role::kMonitor:
      break;
  }
}

ClusterSummary ClusterView::Summarize(TimePoint now) const {
  ClusterSummary summary;
  for (const auto& entry : processes_) {
    const ProcessRow& row = summary.processes.emplace_back(Row(entry.first, entry.second, now));
    Accumulate(row, entry.second, now, summary);
    AppendWaits(row, summary.waits);
    AppendFaults(row, summary.faults);
  }
  std::stable_sort(
      summary.processes.begin(), summary.processes.end(), [](const ProcessRow& a, const ProcessRow& b) {
        return std::pair(DisplayOrder(a.role), a.index) < std::pair(DisplayOrder(b.role), b.index);
      });
  std::stable_sort(summary.waits.begin(), summary.waits.end(),
                   [](const Wait& a, const Wait& b) { return a.fraction > b.fraction; });
  std::stable_partition(summary.faults.begin(), summary.faults.end(),
                        [](const ProcessFault& fault) { return HoldsUpTraining(fault.fault.kind); });
  summary.env_steps = Total(dds::Role::kActor, Metric::kEnvSteps);
  summary.episodes = Total(dds::Role::kActor, Metric::kEpisodes);
  for (const RejectionKind& kind : kRejectionKinds) {
    const double count = Total(kind.role, kind.metric);
    if (count > 0.0) summary.rejected[kind.name] = count;
  }
  AddRecentEpisodes(episodes_, summary);
  return summary;
}

int ClusterView::ReportingProcesses(TimePoint now) const {
  return std::count_if(processes_.begin(), processes_.end(), [&](const auto& entry) {
    return entry.second.history.size() > 1 && !Stale(entry.second, now);
  });
}

}  // namespace dadrl
