#include "deploy/monitor/bottleneck.h"

#include <cmath>

namespace dadrl {
namespace {

// Less waiting than this is not worth a sentence.
constexpr double kNotable = 0.15;
// A learner that computes so much of its time is what limits training.
constexpr double kBusy = 0.9;

struct Shares {
  double learner_work = 0.0;
  double learner_inserts = 0.0;
  double learner_batch = 0.0;
  double learner_disk = 0.0;
  double actor_replay = 0.0;  // means over the actors alive
  double actor_weights = 0.0;
  double actor_simulator = 0.0;
  double replay_inserts = 0.0;  // largest of the shards
  double replay_samples = 0.0;
  double replay_disk = 0.0;
};

Shares Collect(const ClusterSummary& summary) {
  Shares s;
  for (const ProcessRow& row : summary.processes) {
    if (row.stale) continue;
    switch (row.role) {
      case dds::Role::kLearner:
        s.learner_work = row.Share(Activity::kWork);
        s.learner_inserts = row.Share(Activity::kWaitForInserts);
        s.learner_batch = row.Share(Activity::kWaitForBatch);
        s.learner_disk = row.Share(Activity::kWaitForDisk);
        break;
      case dds::Role::kReplay:
        s.replay_inserts = std::max(s.replay_inserts, row.Share(Activity::kWaitForInserts));
        s.replay_samples = std::max(s.replay_samples, row.Share(Activity::kWaitForSamples));
        s.replay_disk = std::max(s.replay_disk, row.Share(Activity::kWaitForDisk));
        break;
      case dds::Role::kActor:
        s.actor_replay += row.Share(Activity::kWaitForReplay) / summary.actors_alive;
        s.actor_weights += row.Share(Activity::kWaitForWeights) / summary.actors_alive;
        s.actor_simulator += row.Share(Activity::kWaitForSimulator) / summary.actors_alive;
        break;
      case dds::Role::kMonitor:
        break;
    }
  }
  return s;
}

// The first role of the cluster nobody hears from.
std::string SilentRole(const ClusterSummary& summary) {
  for (const dds::Role role : {dds::Role::kReplay, dds::Role::kLearner, dds::Role::kActor}) {
    bool known = false;
    bool alive = false;
    for (const ProcessRow& row : summary.processes) {
      known = known || row.role == role;
      alive = alive || (row.role == role && !row.stale);
    }
    if (known && !alive) return fmt::format("no {} reports; the others wait for it", RoleName(role));
    if (!known) return fmt::format("starting: no {} has reported yet", RoleName(role));
  }
  return "";
}

int Percent(double fraction) { return std::lround(100.0 * fraction); }

}  // namespace

std::string Thousands(double value) {
  const std::string digits = fmt::format("{:.0f}", std::abs(value));
  std::string text = value <= -0.5 ? "-" : "";
  for (size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) text += ',';
    text += digits[i];
  }
  return text;
}

std::string DescribeBottleneck(const ClusterSummary& summary, const Config& config) {
  // Those that hold up training stand first.
  if (!summary.faults.empty() && HoldsUpTraining(summary.faults.front().fault.kind)) {
    const ProcessFault& first = summary.faults.front();
    return fmt::format("{}: {}", first.process, first.fault.text);
  }
  if (std::string silent = SilentRole(summary); !silent.empty()) return silent;
  const double min_size = config.replay.min_size;
  if (summary.replay_frames < min_size && summary.updates_per_s == 0.0) {
    return fmt::format("actors: training starts at {} frames, the replay holds {}", Thousands(min_size),
                       Thousands(summary.replay_frames));
  }
  const Shares s = Collect(summary);
  const double learner_starved = s.learner_inserts + s.learner_batch;
  if (s.learner_inserts >= kNotable || (learner_starved >= kNotable && s.replay_inserts >= kNotable)) {
    return fmt::format(
        "actors: the learner waits {} % of its time for new experience; more actors (--actors) or a larger "
        "replay.samples_per_insert would help",
        Percent(learner_starved));
  }
  if (s.replay_disk >= kNotable) {
    return fmt::format("disk: the replay spends {} % of its time on it; replay.sync none would help",
                       Percent(s.replay_disk));
  }
  if (s.learner_batch >= kNotable) {
    return fmt::format(
        "replay: the learner waits {} % of its time for batches; more learner.credits would help",
        Percent(s.learner_batch));
  }
  if (s.learner_disk >= kNotable) {
    return fmt::format("disk: the learner spends {} % of its time on checkpoints", Percent(s.learner_disk));
  }
  if (s.actor_replay >= kNotable) {
    return fmt::format(
        "learner: it computes {} % of its time, and the actors are held back {} % of theirs to keep "
        "replay.min_samples_per_insert",
        Percent(s.learner_work), Percent(s.actor_replay));
  }
  if (s.actor_weights >= kNotable) {
    return fmt::format("learner: the actors wait {} % of their time for a first policy",
                       Percent(s.actor_weights));
  }
  if (s.learner_work >= kBusy) {
    return fmt::format(
        "learner: it computes {} % of its time; faster or more cores (learner.threads) would help",
        Percent(s.learner_work));
  }
  return fmt::format("none stands out: the learner computes {} % of its time", Percent(s.learner_work));
}

}  // namespace dadrl
