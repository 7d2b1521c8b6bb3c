#include "learner/training_log.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "common/util/csv.h"

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

constexpr std::array kColumnsBefore = {
    Column{"wall_time_s", "", [](const Row& r) { return r.context.wall_time_s; }},
    Column{"trained_s", "", [](const Row& r) { return r.training.trained_s; }},
    Column{"cpu_s", "speed/cpu_s", [](const Row& r) { return r.training.cpu_s; }},
    Column{"updates", "", [](const Row& r) -> double { return r.training.updates; }},
    Column{"updates_per_s", "speed/updates_per_s",
           [](const Row& r) { return PerSecond(r, r.training.interval_updates); }},
};

// Between them stand the algorithm's scalars.
constexpr std::array kColumnsBehind = {
    Column{"weights_version", "staleness/weights_version",
           [](const Row& r) -> double { return r.training.weights_version; }},
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

struct Cell {
  std::string_view name;
  std::string_view tag;
  double value;
};

std::vector<Cell> Cells(std::span<const ScalarSpec> scalars, const Row& row) {
  std::vector<Cell> cells;
  for (const Column& column : kColumnsBefore) cells.push_back({column.name, column.tag, column.value(row)});
  for (size_t i = 0; i < scalars.size(); ++i) {
    const bool known = i < row.training.scalars.size();
    cells.push_back({scalars[i].name, scalars[i].tag,
                     known ? row.training.scalars[i] : std::numeric_limits<double>::quiet_NaN()});
  }
  for (const Column& column : kColumnsBehind) cells.push_back({column.name, column.tag, column.value(row)});
  return cells;
}

// 0: none, or not a number.
double FirstCell(std::string_view row) {
  double value = 0.0;
  std::from_chars(row.data(), row.data() + row.size(), value);
  return std::isfinite(value) ? value : 0.0;
}

}  // namespace

TrainingLog::TrainingLog(const std::filesystem::path& run_directory, uint64_t updates,
                         std::span<const ScalarSpec> scalars, FaultBoard& faults)
    : run_directory_(run_directory),
      first_step_(static_cast<int64_t>(updates)),
      scalars_(scalars),
      faults_(faults) {
  const Status table = OpenTable();
  const Status events = OpenEvents();
  faults_.Report(FaultKind::kTrainingLog, table ? events : table);
}

Status TrainingLog::OpenTable() {
  if (table_) return {};
  std::vector<std::string_view> names;
  for (const Cell& cell : Cells(scalars_, {TrainingInterval{}, LogContext{}})) names.push_back(cell.name);
  const std::string header = fmt::format("{}", fmt::join(names, ","));
  return RowFile::Open(run_directory_ / "logs" / "training.csv", header).map([this](RowFile&& table) {
    wall_time_s_ = std::max(wall_time_s_, FirstCell(table.last_row()));
    table_.emplace(std::move(table));
  });
}

Status TrainingLog::OpenEvents() {
  if (tensorboard_) return {};
  return TensorBoardWriter::Create(run_directory_ / "tensorboard", first_step_)
      .map([this](TensorBoardWriter&& writer) { tensorboard_.emplace(std::move(writer)); });
}

void TrainingLog::Add(const TrainingInterval& interval, const LogContext& measured) {
  LogContext context = measured;
  if (context.wall_time_s <= wall_time_s_) context.wall_time_s = wall_time_s_ + context.interval_s;
  wall_time_s_ = context.wall_time_s;
  faults_.Report(FaultKind::kTrainingLog, Write(interval, context));
}

// One that cannot be written does not keep the other from its row.
Status TrainingLog::Write(const TrainingInterval& interval, const LogContext& context) {
  std::vector<std::string> row;
  std::vector<TaggedScalar> tagged;
  for (const Cell& cell : Cells(scalars_, {interval, context})) {
    row.push_back(CsvCell(cell.value));
    if (!cell.tag.empty()) tagged.push_back({cell.tag, cell.value});
  }
  Status table = OpenTable();
  if (table) table = table_->Append(fmt::format("{}\n", fmt::join(row, ",")));
  Status events = OpenEvents();
  if (events) events = tensorboard_->Add(static_cast<int64_t>(interval.updates), context.wall_time_s, tagged);
  return table ? events : table;
}

}  // namespace dadrl
