#include "proto/evaluation/episode_row.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <span>
#include <vector>

#include "common/util/csv.h"
#include "proto/evaluation/summary_fields.h"

namespace dadrl {
namespace {

// Cells that both tables have at the same place.
constexpr size_t kTime = 0;
constexpr size_t kActor = 1;  // of the run's table; the incarnation in an actor's
constexpr size_t kEpisode = 2;
constexpr size_t kSteps = 5;
// Of an actor's: the first of kSummaryFields. Behind the last stand policy version and scenario.
constexpr size_t kFields = 6;

// `who`: the second column.
std::string Columns(std::string_view who, bool of_run) {
  std::string text = fmt::format("time_s,{},episode,seed,outcome,steps", who);
  for (const SummaryField& field : kSummaryFields) {
    if (!of_run || field.in_run_table) text.append(",").append(field.name);
  }
  return text + ",policy_version,scenario";
}

size_t CellsIn(std::string_view columns) {
  return 1 + static_cast<size_t>(std::count(columns.begin(), columns.end(), ','));
}

template <typename T>
bool Parse(std::string_view cell, T& value) {
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return error == std::errc() && end == cell.data() + cell.size();
}

std::optional<EpisodeKey> KeyOf(std::span<const std::string_view> cells, std::string_view columns) {
  EpisodeKey key;
  if (cells.size() != CellsIn(columns) || !Parse(cells[kTime], key.time_s) || !std::isfinite(key.time_s) ||
      !Parse(cells[kEpisode], key.episode) || !Parse(cells[kSteps], key.steps)) {
    return std::nullopt;
  }
  return key;
}

}  // namespace

const std::string& ActorEpisodeColumns() {
  static const std::string columns = Columns("incarnation", false);
  return columns;
}

const std::string& RunEpisodeColumns() {
  static const std::string columns = Columns("actor", true);
  return columns;
}

std::string ActorEpisodeRow(const TrainingEpisode& episode) {
  const EpisodeSummary& summary = episode.summary;
  std::string row = fmt::format("{:.3f},{},{},{},{},{}", 1e-9 * episode.wall_time_ns, episode.incarnation,
                                episode.episode, summary.seed, OutcomeName(summary.outcome), summary.steps);
  for (const SummaryField& field : kSummaryFields) row += fmt::format(",{:.6g}", summary.*field.value);
  return row + fmt::format(",{},{}\n", episode.policy_version, CsvCell(summary.scenario));
}

std::optional<EpisodeKey> ActorEpisodeKey(std::string_view row) {
  return KeyOf(CsvCells(row), ActorEpisodeColumns());
}

std::optional<EpisodeKey> RunEpisodeKey(std::string_view row, int& actor) {
  const std::vector<std::string_view> cells = CsvCells(row);
  const auto key = KeyOf(cells, RunEpisodeColumns());
  if (!key || !Parse(cells[kActor], actor)) return std::nullopt;
  return key;
}

std::string RunEpisodeRow(int actor, std::string_view actor_row) {
  const std::vector<std::string_view> cells = CsvCells(actor_row);
  std::string row = fmt::format("{},{}", cells[kTime], actor);
  const auto append = [&](size_t cell) { row.append(",").append(cells[cell]); };
  for (size_t cell = kEpisode; cell < kFields; ++cell) append(cell);
  for (size_t i = 0; i < kSummaryFields.size(); ++i) {
    if (kSummaryFields[i].in_run_table) append(kFields + i);
  }
  for (size_t cell = kFields + kSummaryFields.size(); cell < cells.size(); ++cell) append(cell);
  return row + '\n';
}

}  // namespace dadrl
