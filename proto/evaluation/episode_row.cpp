#include "proto/evaluation/episode_row.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <span>
#include <vector>

#include "common/util/csv.h"

namespace dadrl {
namespace {

// Cells that both tables have at the same place.
constexpr size_t kTime = 0;
constexpr size_t kActor = 1;  // of the run's table; the incarnation in an actor's
constexpr size_t kEpisode = 2;
constexpr size_t kSteps = 5;
// Cells of an actor's row that are in the run's, in its order, behind time and actor.
constexpr std::array<size_t, 11> kShared = {2, 3, 4, 5, 6, 7, 8, 9, 16, 17, 18};

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

std::string ActorEpisodeRow(const TrainingEpisode& episode) {
  const EpisodeSummary& s = episode.summary;
  return fmt::format(
      "{:.3f},{},{},{},{},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{},"
      "{}\n",
      1e-9 * static_cast<double>(episode.wall_time_ns), episode.incarnation, episode.episode, s.seed,
      OutcomeName(s.outcome), s.steps, s.episode_return, s.progress, s.mean_speed_mps, s.humanness_error,
      s.obstacle_cost, s.jerk_cost, s.lane_offset_cost, s.rule_violation, s.distance_to_destination,
      s.time_cost, s.overall_score, episode.policy_version, CsvCell(s.scenario));
}

std::optional<EpisodeKey> ActorEpisodeKey(std::string_view row) {
  return KeyOf(CsvCells(row), kActorEpisodeColumns);
}

std::optional<EpisodeKey> RunEpisodeKey(std::string_view row, int& actor) {
  const std::vector<std::string_view> cells = CsvCells(row);
  const auto key = KeyOf(cells, kRunEpisodeColumns);
  if (!key || !Parse(cells[kActor], actor)) return std::nullopt;
  return key;
}

std::string RunEpisodeRow(int actor, std::string_view actor_row) {
  const std::vector<std::string_view> cells = CsvCells(actor_row);
  std::string row = fmt::format("{},{}", cells[kTime], actor);
  for (const size_t cell : kShared) row.append(",").append(cells[cell]);
  return row + '\n';
}

}  // namespace dadrl
