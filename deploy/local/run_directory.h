// The directory one run lives in, and the lock that gives it to one launcher at a time.
#pragma once

#include <filesystem>
#include <string>

#include "common/config/config.h"
#include "common/io/file_descriptor.h"
#include "common/util/result.h"

namespace dadrl {

// Where things are in a run directory.
struct RunPaths {
  std::filesystem::path root;

  std::filesystem::path config() const { return root / "config.yaml"; }
  std::filesystem::path checkpoints() const { return root / "checkpoints"; }
  std::filesystem::path replay() const { return root / "replay"; }
  std::filesystem::path logs() const { return root / "logs"; }
  // The learner's curves, a row an interval.
  std::filesystem::path training() const { return logs() / "training.csv"; }
  std::filesystem::path tensorboard() const { return root / "tensorboard"; }
  std::filesystem::path episodes() const { return root / "episodes.csv"; }
  std::filesystem::path results() const { return root / "results.json"; }
  // The choice among the last policies: candidates, their figures, seeds (policy_selection.h).
  std::filesystem::path selection() const { return root / "selection.json"; }
  std::filesystem::path lock() const { return root / "lock"; }
  // What the launcher knows of its processes (deploy/monitor/supervision.h).
  std::filesystem::path processes() const { return root / "processes.json"; }
  // The newest policy that the learner saved: its link, replaced with every checkpoint.
  std::filesystem::path policy() const { return checkpoints() / "latest"; }
  // The policy that was chosen when training ended: a link; not there while training goes on.
  std::filesystem::path best_policy() const { return checkpoints() / "best"; }
};

// A run directory held by this process: nobody else can open it. The kernel releases the lock when the
// process ends, however it ends, so a lock left by a crash is no obstacle.
class RunDirectory {
 public:
  // Creates `root` with its folders for a new run. kInvalidArgument when it holds a run already or is not a
  // folder; kUnavailable when another process uses it.
  static Result<RunDirectory> CreateNew(const std::filesystem::path& root);
  // Opens an existing run to go on with it. kNotFound when there is none. Like CreateNew kInvalidArgument
  // when `lock` is no file of the run's own: a link, or one that has another name elsewhere.
  static Result<RunDirectory> OpenExisting(const std::filesystem::path& root);

  const RunPaths& paths() const { return paths_; }
  // The lock goes on with the program that this process becomes (exec), until that ends.
  void KeepAcrossExec() const;
  // Writes config.yaml, unless it says the same already: a run can be resumed on a full disk.
  Status SaveConfig(const Config& config) const;

 private:
  RunDirectory(RunPaths paths, FileDescriptor lock) : paths_(std::move(paths)), lock_(std::move(lock)) {}
  static Result<RunDirectory> Lock(RunPaths paths);

  RunPaths paths_;
  FileDescriptor lock_;
};

// The configuration of a run, of its own config.yaml: not of what a link there names. Overlays `config`.
Status LoadRunConfig(const RunPaths& paths, Config& config);

// True when a launcher holds the run directory now.
bool IsRunning(const RunPaths& paths);

// `runs/<scenario>-<local time>`, with a suffix when that exists.
std::filesystem::path NewRunPath(const std::filesystem::path& runs, const std::string& scenario);

// Points `<parent>/latest` at the run (common/io/link_file.h); best effort.
void LinkLatest(const std::filesystem::path& root);

}  // namespace dadrl
