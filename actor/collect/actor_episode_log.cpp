#include "actor/collect/actor_episode_log.h"

#include <algorithm>
#include <string_view>
#include <tuple>

#include "common/io/each_line.h"
#include "proto/evaluation/episode_row.h"

namespace dadrl {
namespace {

constexpr size_t kMostWaiting = size_t{1} << 20;

// Not the last row's: before numbers went on over restarts, each start began with 1.
uint64_t LastEpisode(const std::filesystem::path& path) {
  uint64_t last = 0;
  ForEachLine(path, [&last](std::string_view row) {
    if (const auto key = ActorEpisodeKey(row)) last = std::max(last, key->episode);
  });
  return last;
}

}  // namespace

ActorEpisodeLog ActorEpisodeLog::Open(const std::filesystem::path& path) {
  ActorEpisodeLog log(path, LastEpisode(path));
  std::ignore = log.OpenTable();  // the first row says what is wrong, if it still is
  return log;
}

Status ActorEpisodeLog::OpenTable() {
  if (table_) return {};
  return RowFile::Open(path_, ActorEpisodeColumns()).map([this](RowFile&& table) {
    table_.emplace(std::move(table));
  });
}

Status ActorEpisodeLog::Append(uint64_t incarnation, int64_t wall_time_ns, const CollectedEpisode& episode) {
  if (waiting_.size() < kMostWaiting) {
    waiting_ += ActorEpisodeRow({.wall_time_ns = wall_time_ns,
                                 .incarnation = incarnation,
                                 .episode = episode.episode,
                                 .policy_version = episode.policy_version,
                                 .summary = episode.summary});
  }
  DADRL_RETURN_IF_ERROR(OpenTable());
  DADRL_RETURN_IF_ERROR(table_->Append(waiting_));
  waiting_.clear();
  return {};
}

}  // namespace dadrl
