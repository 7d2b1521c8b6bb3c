// The checkpoints folder of a run: what is written there, what is kept, and which one a resumed run takes.
//
//   checkpoint-<updates>.ckpt  everything a resumed training needs
//   policy-<updates>.dadrl     its networks; small, so that more of them can stay
//   latest                     link to the newest policy
//   *.ckpt.corrupt             damaged checkpoints that a resume has set aside
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "common/config/config.h"
#include "common/util/result.h"
#include "learner/checkpoint.h"

namespace dadrl {

// How many of the newest stay, each at least 1.
struct Retention {
  int checkpoints = 1;
  int policies = 1;
  // learner.checkpoints_kept, and as many policies or evaluation.candidates if that is more.
  static Retention Of(const Config& config);
};

// Not thread safe; every call may block on the disk. At most one process uses a folder.
class CheckpointStore {
 public:
  // Creates the folder and removes what a killed writer left.
  static Result<CheckpointStore> Open(const std::filesystem::path& directory, Retention kept);

  // Policy, then checkpoint, then `latest`; each atomic. Then removes the oldest ones beyond `kept`, and
  // policies newer than this one: those of a future that a resume has given up. On an
  // error all earlier checkpoints stay.
  Status Save(const Checkpoint& checkpoint);

  struct Loaded {
    std::filesystem::path path;
    Checkpoint checkpoint;
  };
  // The newest whole checkpoint; nothing when there is none at all. A damaged one is logged with its remedy,
  // renamed to *.corrupt, and the one before it is tried; kCorrupt when all are damaged. Other errors (no
  // permission, another format) are returned: an older checkpoint would hide them.
  Result<std::optional<Loaded>> LoadNewest();

  // Whether any checkpoint is there, whole or not.
  bool empty() const;
  const std::filesystem::path& directory() const { return directory_; }

 private:
  CheckpointStore(std::filesystem::path directory, Retention kept)
      : directory_(std::move(directory)), kept_(kept) {}
  // `newest`: updates of the checkpoint just saved.
  void Prune(uint64_t newest);

  std::filesystem::path directory_;
  Retention kept_;
};

}  // namespace dadrl
