#include "learner/checkpoint_store.h"

#include <algorithm>
#include <charconv>
#include <functional>
#include <map>
#include <string_view>

#include "common/io/atomic_file.h"
#include "common/io/link_file.h"
#include "common/model/policy_file.h"
#include "common/util/log.h"

namespace dadrl {
namespace {

constexpr std::string_view kCheckpointPrefix = "checkpoint-";
constexpr std::string_view kCheckpointSuffix = ".ckpt";
constexpr std::string_view kPolicyPrefix = "policy-";
constexpr std::string_view kPolicySuffix = ".dadrl";

// Zero-padded, so that the shell lists them in order.
std::string CheckpointName(uint64_t updates) {
  return fmt::format("{}{:09}{}", kCheckpointPrefix, updates, kCheckpointSuffix);
}
std::string PolicyName(uint64_t updates) {
  return fmt::format("{}{:09}{}", kPolicyPrefix, updates, kPolicySuffix);
}

std::optional<uint64_t> NumberIn(std::string_view name, std::string_view prefix, std::string_view suffix) {
  if (!name.starts_with(prefix) || !name.ends_with(suffix) || name.size() <= prefix.size() + suffix.size()) {
    return std::nullopt;
  }
  const std::string_view digits = name.substr(prefix.size(), name.size() - prefix.size() - suffix.size());
  uint64_t number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
  return number;
}

using Files = std::map<uint64_t, std::filesystem::path, std::greater<>>;  // newest first

Files ListFiles(const std::filesystem::path& directory, std::string_view prefix, std::string_view suffix) {
  Files files;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(directory, ignored)) {
    const auto number = NumberIn(entry.path().filename().string(), prefix, suffix);
    if (number) files.emplace(*number, entry.path());
  }
  return files;
}

// Removes all but the newest `kept`. A file that cannot be removed is tried again at the next checkpoint.
void RemoveBeyond(int kept, const Files& files) {
  std::error_code ignored;
  for (const auto& [number, path] : files) {
    if (kept-- <= 0) std::filesystem::remove(path, ignored);
  }
}

void SetAside(const std::filesystem::path& path, const Error& error) {
  std::filesystem::path aside = path;
  aside += ".corrupt";
  std::error_code failed;
  std::filesystem::rename(path, aside, failed);
  spdlog::warn("{}; {}", error.message,
               failed ? "it could not be renamed: " + failed.message() : "set aside as " + aside.string());
}

}  // namespace

Retention Retention::Of(const Config& config) {
  const int checkpoints = config.learner.checkpoints_kept;
  return {.checkpoints = checkpoints, .policies = std::max(checkpoints, config.evaluation.candidates)};
}

Result<CheckpointStore> CheckpointStore::Open(const std::filesystem::path& directory, Retention kept) {
  std::error_code failed;
  std::filesystem::create_directories(directory, failed);
  if (failed) {
    return Fail(ErrorCode::kInternal, "cannot create {}: {}; choose another run directory",
                directory.string(), failed.message());
  }
  RemoveLeftoverTemporaries(directory);
  return CheckpointStore(directory, kept);
}

Status CheckpointStore::Save(const Checkpoint& checkpoint) {
  const std::string policy_name = PolicyName(checkpoint.updates);
  PolicyToSave policy{.policy_version = checkpoint.weights_version,
                      .updates = checkpoint.updates,
                      .config_yaml = checkpoint.config_yaml,
                      .networks = {}};
  for (const StoredNetwork& network : checkpoint.networks) policy.networks.push_back(network.view());
  DADRL_RETURN_IF_ERROR(SavePolicy(directory_ / policy_name, policy));
  const Status saved = SaveCheckpoint(directory_ / CheckpointName(checkpoint.updates), checkpoint);
  if (!saved) {
    // Policies without a checkpoint would fill up what room is left, one with each attempt.
    std::error_code ignored;
    std::filesystem::remove(directory_ / policy_name, ignored);
    return saved;
  }
  DADRL_RETURN_IF_ERROR(LinkAtomically(directory_ / "latest", policy_name));
  Prune(checkpoint.updates);
  return {};
}

Result<std::optional<CheckpointStore::Loaded>> CheckpointStore::LoadNewest() {
  const Files files = ListFiles(directory_, kCheckpointPrefix, kCheckpointSuffix);
  for (const auto& [updates, path] : files) {
    auto checkpoint = LoadCheckpoint(path);
    if (checkpoint) return Loaded{path, std::move(*checkpoint)};
    if (checkpoint.error().code != ErrorCode::kCorrupt) {
      return tl::unexpected<Error>(std::move(checkpoint.error()));
    }
    SetAside(path, checkpoint.error());
  }
  if (files.empty()) return std::optional<Loaded>();
  return Fail(ErrorCode::kCorrupt, "all {} checkpoints in {} are damaged: start a new run directory",
              files.size(), directory_.string());
}

bool CheckpointStore::empty() const {
  return ListFiles(directory_, kCheckpointPrefix, kCheckpointSuffix).empty();
}

void CheckpointStore::Prune(uint64_t newest) {
  RemoveBeyond(kept_.checkpoints, ListFiles(directory_, kCheckpointPrefix, kCheckpointSuffix));
  Files policies = ListFiles(directory_, kPolicyPrefix, kPolicySuffix);
  // Training went back behind these: their checkpoint was damaged or never completed.
  const auto first_valid = policies.lower_bound(newest);
  RemoveBeyond(0, Files(policies.begin(), first_valid));
  policies.erase(policies.begin(), first_valid);
  RemoveBeyond(kept_.policies, policies);
}

}  // namespace dadrl
