#include "deploy/local/experience_copy.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <system_error>

#include "common/config/config_schema.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

// A key or, ending in a dot, a section: what stored frames depend on.
constexpr std::array<std::string_view, 5> kOfExperience = {"task.", "observation.", "model.log_probability",
                                                           "algorithm.gamma", "replay.shards"};

Status CheckSameSteps(const fs::path& from, Config theirs, Config ours) {
  const std::vector<ConfigField> stored = SchemaOf(theirs);
  const std::vector<ConfigField> wanted = SchemaOf(ours);
  for (size_t i = 0; i < stored.size(); ++i) {
    const std::string was = FormatValue(stored[i]);
    const std::string is = FormatValue(wanted[i]);
    const bool counts = std::ranges::any_of(
        kOfExperience, [&](std::string_view key) { return stored[i].key.starts_with(key); });
    if (was == is || !counts) continue;
    return Fail(ErrorCode::kInvalidArgument,
                "--experience: {} was stored with {}: {}, this run has {}; set it", from.string(),
                stored[i].key, was, is);
  }
  return {};
}

// Who serves it, and what that one counted, is no part of the experience.
bool IsExperience(const fs::directory_entry& entry) {
  const fs::path name = entry.path().filename();
  return entry.is_regular_file() && !entry.is_symlink() && name != "lock" && name != "state";
}

Status CopyShard(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::create_directories(to, error);
  fs::directory_iterator entries(from, error);
  for (; !error && entries != fs::directory_iterator(); entries.increment(error)) {
    if (!IsExperience(*entries)) continue;
    fs::copy_file(entries->path(), to / entries->path().filename(), fs::copy_options::overwrite_existing,
                  error);
    if (error) break;
  }
  if (!error) return {};
  return Fail(ErrorCode::kInternal, "cannot copy the experience of {} to {}: {}", from.string(), to.string(),
              error.message());
}

}  // namespace

Status CopyExperience(const fs::path& from, const RunPaths& to, const Config& config) {
  const RunPaths source{.root = from};
  std::error_code error;
  if (!fs::exists(source.config(), error)) {
    return Fail(ErrorCode::kNotFound,
                "--experience: {} holds no run (no config.yaml); dadrl collect SCENARIO --out {} makes one",
                from.string(), from.string());
  }
  if (IsRunning(source)) {
    return Fail(ErrorCode::kUnavailable, "--experience: {} is being written; wait for its end",
                from.string());
  }
  if (config.actor.count == 0 && config.replay.samples_per_insert > 0.0) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "replay.samples_per_insert: {} waits for inserts, and without actors (actor.count: 0) there are "
        "none; set it to 0",
        config.replay.samples_per_insert);
  }
  Config stored;
  DADRL_RETURN_IF_ERROR(LoadRunConfig(source, stored));
  DADRL_RETURN_IF_ERROR(CheckSameSteps(from, stored, config));
  for (int shard = 0; shard < config.replay.shards; ++shard) {
    const std::string name = fmt::format("shard-{}", shard);
    DADRL_RETURN_IF_ERROR(CopyShard(source.replay() / name, to.replay() / name));
  }
  return {};
}

}  // namespace dadrl
