#include "learner/training_log.h"

#include <array>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "common/util/log.h"

namespace dadrl {
namespace {

struct Row {
  const TrainingInterval& training;
  const LogContext& context;
};

struct Column {
  std::string_view name;  // in the table
  std::string_view tag;   // in TensorBoard; empty: only in the table
  double (*value)(const Row&);
};

// Averages of an interval without updates do not exist.
double OfUpdates(const Row& row, double value) {
  return row.training.interval_updates > 0 ? value : std::numeric_limits<double>::quiet_NaN();
}

double PerSecond(const Row& row, double value) {
  return row.context.interval_s > 0.0 ? value / row.context.interval_s : 0.0;
}

constexpr std::array kColumns = {
    Column{"wall_time_s", "", [](const Row& r) { return r.context.wall_time_s; }},
    Column{"trained_s", "", [](const Row& r) { return r.training.trained_s; }},
    Column{"updates", "", [](const Row& r) { return static_cast<double>(r.training.updates); }},
    Column{"updates_per_s", "speed/updates_per_s",
           [](const Row& r) { return PerSecond(r, static_cast<double>(r.training.interval_updates)); }},
    Column{"critic_loss", "loss/critic",
           [](const Row& r) { return OfUpdates(r, r.training.mean.critic_loss); }},
    Column{"actor_loss", "loss/actor", [](const Row& r) { return OfUpdates(r, r.training.mean.actor_loss); }},
    Column{"temperature_loss", "loss/temperature",
           [](const Row& r) { return OfUpdates(r, r.training.mean.temperature_loss); }},
    Column{"temperature", "policy/temperature",
           [](const Row& r) { return OfUpdates(r, r.training.mean.temperature); }},
    Column{"entropy", "policy/entropy", [](const Row& r) { return OfUpdates(r, r.training.mean.entropy); }},
    Column{"mean_q", "value/mean_q", [](const Row& r) { return OfUpdates(r, r.training.mean.mean_q); }},
    Column{"mean_target", "value/mean_target",
           [](const Row& r) { return OfUpdates(r, r.training.mean.mean_target); }},
    Column{"weights_version", "staleness/weights_version",
           [](const Row& r) { return static_cast<double>(r.training.weights_version); }},
    Column{"staleness_versions_mean", "staleness/versions_mean",
           [](const Row& r) { return OfUpdates(r, r.training.staleness.versions_mean); }},
    Column{"staleness_versions_max", "staleness/versions_max",
           [](const Row& r) { return OfUpdates(r, r.training.staleness.versions_max); }},
    Column{"staleness_s_mean", "staleness/s_mean",
           [](const Row& r) { return OfUpdates(r, r.training.staleness.seconds_mean); }},
    Column{"staleness_s_max", "staleness/s_max",
           [](const Row& r) { return OfUpdates(r, r.training.staleness.seconds_max); }},
    Column{"batch_mb_per_s", "speed/batch_mb_per_s",
           [](const Row& r) { return PerSecond(r, 1e-6 * r.context.batch_bytes); }},
    Column{"work_fraction", "speed/work_fraction", [](const Row& r) { return r.context.work_fraction; }},
    Column{"replay_frames", "replay/frames", [](const Row& r) { return r.context.replay_frames; }},
};

}  // namespace

Result<TrainingLog> TrainingLog::Open(const std::filesystem::path& run_directory, uint64_t updates) {
  std::vector<std::string> names;
  for (const Column& column : kColumns) names.emplace_back(column.name);
  auto csv = CsvLog::Open(run_directory / "logs" / "training.csv", names);
  if (!csv) return tl::unexpected<Error>(std::move(csv.error()));
  auto tensorboard = TensorBoardWriter::Create(run_directory / "tensorboard", static_cast<int64_t>(updates));
  if (!tensorboard) return tl::unexpected<Error>(std::move(tensorboard.error()));
  return TrainingLog(std::move(*csv), std::move(*tensorboard));
}

void TrainingLog::Add(const TrainingInterval& interval, const LogContext& measured) {
  LogContext context = measured;
  if (context.wall_time_s <= wall_time_s_) context.wall_time_s = wall_time_s_ + context.interval_s;
  wall_time_s_ = context.wall_time_s;
  const Row row{interval, context};
  std::vector<double> values;
  std::vector<TaggedScalar> scalars;
  for (const Column& column : kColumns) {
    values.push_back(column.value(row));
    if (!column.tag.empty()) scalars.push_back({column.tag, values.back()});
  }
  Status written = csv_.Append(values);
  const Status events =
      tensorboard_.Add(static_cast<int64_t>(interval.updates), context.wall_time_s, scalars);
  if (written) written = events;
  if (!written && !failing_) spdlog::error("training log: {}", written.error().message);
  failing_ = !written;
}

}  // namespace dadrl
