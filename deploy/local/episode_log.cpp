#include "deploy/local/episode_log.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "common/io/each_line.h"
#include "proto/evaluation/episode_row.h"

namespace dadrl {
namespace {

// Of one actor's log at a time; more follows with the next update.
constexpr size_t kMostBytes = size_t{4} << 20;

// N of "episodes-actor-N.csv".
std::optional<int> ActorOf(std::string_view name) {
  constexpr std::string_view kBefore = "episodes-actor-";
  constexpr std::string_view kAfter = ".csv";
  if (!name.starts_with(kBefore) || !name.ends_with(kAfter)) return std::nullopt;
  name.remove_prefix(kBefore.size());
  name.remove_suffix(std::min(name.size(), kAfter.size()));
  int actor = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), actor);
  if (error != std::errc() || end != name.data() + name.size() || actor < 0) return std::nullopt;
  return actor;
}

// The whole lines of a file from `offset` on; empty when there are none or it cannot be read.
std::string WholeLines(const std::filesystem::path& path, uint64_t offset) {
  const auto file = FileDescriptor::Open(path, O_RDONLY);
  std::error_code failed;
  const uint64_t size = std::filesystem::file_size(path, failed);
  if (!file || failed || size <= offset) return "";
  std::string text(std::min<uint64_t>(kMostBytes, size - offset), '\0');
  const ssize_t bytes = pread(file->get(), text.data(), text.size(), static_cast<off_t>(offset));
  text.resize(bytes > 0 ? static_cast<size_t>(bytes) : 0);
  text.resize(text.rfind('\n') + 1);
  return text;
}

// Calls `visit(line, bytes)` for each of the whole lines; `bytes` counts its line break.
template <typename Visit>
void ForEachWholeLine(std::string_view text, Visit visit) {
  while (!text.empty()) {
    const size_t end = text.find('\n');
    visit(text.substr(0, end), end + 1);
    text.remove_prefix(end + 1);
  }
}

}  // namespace

// Rows that are not in the table yet, and what is known when they are.
struct EpisodeLog::NewRows {
  struct Row {
    EpisodeKey key;
    std::string text;
  };
  std::vector<Row> rows;
  std::map<int, uint64_t> read;  // by actor

  void Take(int actor, const Actor& known, std::string_view text) {
    // Of another version of the program: its actor will start a new one in its place.
    if (known.read == 0 && !text.starts_with(ActorEpisodeColumns())) return;
    uint64_t at = known.read;
    ForEachWholeLine(text, [&](std::string_view line, size_t bytes) {
      const auto key = ActorEpisodeKey(line);  // nothing for the header
      const bool in_table = key && at < known.known_end && key->episode <= known.last_episode;
      if (key && !in_table) rows.push_back({*key, RunEpisodeRow(actor, line)});
      at += bytes;
    });
    read[actor] = at;
  }
};

template <typename Visit>
void EpisodeLog::ForEachLog(Visit visit) const {
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(logs_, ignored)) {
    if (const auto actor = ActorOf(entry.path().filename().native())) visit(*actor, entry.path());
  }
}

Result<EpisodeLog> EpisodeLog::Open(const std::filesystem::path& path, const std::filesystem::path& logs) {
  DADRL_ASSIGN_OR_RETURN(RowFile table, RowFile::Open(path, RunEpisodeColumns()));
  EpisodeLog log(std::move(table), logs);
  log.CountTable(path);
  log.ForEachLog([&](int actor, const std::filesystem::path& file) {
    std::error_code failed;
    const uint64_t bytes = std::filesystem::file_size(file, failed);
    if (!failed) log.actors_[actor].known_end = bytes;
  });
  return log;
}

void EpisodeLog::CountTable(const std::filesystem::path& path) {
  ForEachLine(path, [this](std::string_view line) {
    int actor = 0;
    const auto key = RunEpisodeKey(line, actor);
    if (!key) return;
    ++episodes_;
    env_steps_ += key->steps;
    uint64_t& last = actors_[actor].last_episode;
    last = std::max(last, key->episode);
  });
}

Status EpisodeLog::Update() {
  NewRows added;
  ForEachLog([&](int actor, const std::filesystem::path& file) {
    const Actor& known = actors_[actor];
    added.Take(actor, known, WholeLines(file, known.read));
  });
  std::stable_sort(added.rows.begin(), added.rows.end(),
                   [](const NewRows::Row& a, const NewRows::Row& b) { return a.key.time_s < b.key.time_s; });
  std::string text;
  uint64_t steps = 0;
  for (const NewRows::Row& row : added.rows) {
    text += row.text;
    steps += row.key.steps;
  }
  if (!text.empty()) DADRL_RETURN_IF_ERROR(table_.Append(text));
  for (const auto& [actor, read] : added.read) actors_[actor].read = read;
  episodes_ += added.rows.size();
  env_steps_ += steps;
  return {};
}

}  // namespace dadrl
