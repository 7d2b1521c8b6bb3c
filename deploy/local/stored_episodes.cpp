#include "deploy/local/stored_episodes.h"

#include <utility>

#include "common/io/json_text.h"
#include "deploy/local/executables.h"

namespace dadrl {
namespace {

Result<StoredEpisodes> Read(const std::string& text) {
  DADRL_ASSIGN_OR_RETURN(const nlohmann::ordered_json json, ParseJson(text, "dadrl-replay tool inspect"));
  JsonFields fields(json);
  StoredEpisodes stored{.frames = fields.Whole("transitions", UINT64_MAX)};
  const nlohmann::ordered_json* const ends = fields.Find("ends");
  if (ends == nullptr || !fields.ok()) return Fail(ErrorCode::kInternal, "dadrl-replay counts no episodes");
  JsonFields by_end(*ends);
  stored.episodes = by_end.Whole("terminated", UINT64_MAX) + by_end.Whole("truncated", UINT64_MAX);
  stored.successes = by_end.Whole("by_success", UINT64_MAX);
  if (!by_end.ok()) return Fail(ErrorCode::kInternal, "dadrl-replay counts no '{}'", by_end.bad());
  return stored;
}

}  // namespace

Status StoredEpisodeCounter::Begin() {
  if (process_) return {};
  DADRL_ASSIGN_OR_RETURN(const auto program, FindExecutable("dadrl-replay"));
  DADRL_ASSIGN_OR_RETURN(process_, CapturedProcess::Spawn({program, "tool", "inspect", "--json", replay_}));
  return {};
}

void StoredEpisodeCounter::AppendWaitFds(std::vector<pollfd>& fds) const {
  if (process_) fds.push_back({.fd = process_->child().pidfd(), .events = POLLIN, .revents = 0});
}

std::vector<pid_t> StoredEpisodeCounter::RunningPids() const {
  return process_ ? std::vector<pid_t>{process_->child().pid()} : std::vector<pid_t>();
}

std::optional<Result<StoredEpisodes>> StoredEpisodeCounter::Step() {
  if (!process_) return std::nullopt;
  const std::optional<ExitStatus> ended = process_->child().TryWait();
  if (!ended) return std::nullopt;
  const CapturedProcess process = std::move(*process_);
  process_.reset();
  if (ended->signaled || ended->value != 0) {
    return Fail(ErrorCode::kInternal, "cannot count what is stored: {}", process.LastMessage());
  }
  return Read(process.Output());
}

}  // namespace dadrl
