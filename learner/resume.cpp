#include "learner/resume.h"

#include <algorithm>

#include "common/config/config_yaml.h"
#include "common/util/log.h"

namespace dadrl {
namespace {

Status Restore(const Config& config, const CheckpointStore::Loaded& loaded, Algorithm& algorithm) {
  Config saved;
  DADRL_RETURN_IF_ERROR(ParseYaml(loaded.checkpoint.config_yaml, loaded.path.string(), saved));
  DADRL_RETURN_IF_ERROR(CheckSameNetworks(saved, config, loaded.path));
  return RestoreState(loaded.checkpoint, loaded.path, algorithm);
}

}  // namespace

Result<TrainingProgress> BeginTraining(const Config& config, CheckpointStore& store,
                                       uint32_t highest_reserved_version, bool resume, Algorithm& algorithm) {
  if (!resume && !store.empty()) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "{} holds the checkpoints of an earlier training: continue it with --resume or choose another "
        "--run-dir",
        store.directory().string());
  }
  TrainingProgress progress;
  progress.weights_version = highest_reserved_version;
  if (!resume) return progress;
  DADRL_ASSIGN_OR_RETURN(const std::optional<CheckpointStore::Loaded> loaded, store.LoadNewest());
  if (!loaded) {
    spdlog::warn("no checkpoint in {}: the training starts from the beginning", store.directory().string());
    return progress;
  }
  DADRL_RETURN_IF_ERROR(Restore(config, *loaded, algorithm));
  const Checkpoint& checkpoint = loaded->checkpoint;
  progress.updates = checkpoint.updates;
  progress.trained_s = checkpoint.trained_s;
  progress.cpu_s = checkpoint.cpu_s;
  progress.published_ns = checkpoint.published_ns;
  progress.weights_version = std::max(checkpoint.weights_version, highest_reserved_version);
  if (!progress.published_ns.empty()) {
    // Versions between the checkpoint and the kill: their times are lost, the checkpoint's is the nearest.
    const uint32_t lost = progress.weights_version - checkpoint.weights_version;
    progress.published_ns.resize(
        progress.published_ns.size() + std::min<size_t>(lost, StalenessTracker::kRemembered),
        checkpoint.published_ns.back());
  }
  spdlog::info("resumed {}: {} updates, {:.1f} minutes of training, weights version {}",
               loaded->path.string(), progress.updates, progress.trained_s / 60.0, progress.weights_version);
  return progress;
}

}  // namespace dadrl
