// What is asked of a running replay: other bounds for its rate limiter, a snapshot.
#include <algorithm>
#include <memory>
#include <string>

#include "common/util/clock.h"
#include "replay/storage/snapshot_folder.h"
#include "replay/tools/ask_replay.h"
#include "replay/tools/tool.h"

namespace dadrl {
namespace {

struct LimitOptions {
  std::string run_directory;
  int64_t min_size = 0;
  double samples_per_insert = -1.0;
  double min_samples_per_insert = -1.0;
  double band_frames = 0.0;
  bool json = false;
};

Result<int> Limit(const LimitOptions& options) {
  dadrl_idl_ReplayCommand command{};
  command.kind = static_cast<uint32_t>(ReplayCommandKind::kLimit);
  command.min_size = options.min_size;
  command.samples_per_insert = options.samples_per_insert;
  command.min_samples_per_insert = options.min_samples_per_insert;
  command.band_frames = options.band_frames;
  return AskReplay(options.run_directory, command, options.json);
}

struct SnapshotOptions {
  std::string run_directory;
  std::string name;
  bool json = false;
};

Result<int> TakeSnapshot(const SnapshotOptions& options) {
  const std::string name = options.name.empty() ? AutomaticSnapshotName(WallTimeNs()) : options.name;
  DADRL_RETURN_IF_ERROR(CheckSnapshotName(name));
  dadrl_idl_ReplayCommand command{};
  command.kind = static_cast<uint32_t>(ReplayCommandKind::kSnapshot);
  std::copy(name.begin(), name.end(), command.snapshot);  // CheckSnapshotName bounds it
  return AskReplay(options.run_directory, command, options.json);
}

void AddCommon(CLI::App& app, std::string& run_directory, bool& json) {
  app.add_option("--run-dir", run_directory, "The run, which must be running (default: runs/latest)")
      ->default_str("runs/latest")
      ->type_name("DIR");
  app.add_flag("--json", json, "One JSON object on standard output");
}

}  // namespace

Tool MakeLimitTool(CLI::App& replay) {
  auto options = std::make_shared<LimitOptions>();
  options->run_directory = "runs/latest";
  CLI::App* app = replay.add_subcommand(
      "limit", "Change a running replay's rate limiter; without an option, show it. Each shard has its own");
  app->add_option("--min-size", options->min_size, "Frames before the first sample")
      ->check(CLI::Range(int64_t{1}, int64_t{1} << 50));
  app->add_option("--samples-per-insert", options->samples_per_insert,
                  "Sampled transitions per inserted frame above which sampling waits; 0 is never")
      ->check(CLI::Range(0.0, 1e6));
  app->add_option("--min-samples-per-insert", options->min_samples_per_insert,
                  "Sampled transitions per inserted frame below which actors wait; 0 is never")
      ->check(CLI::Range(0.0, 1e6));
  app->add_option("--band", options->band_frames, "Tolerated deviation of both, in inserted frames")
      ->check(CLI::Range(1.0, 1e12));
  AddCommon(*app, options->run_directory, options->json);
  return {app, [options] { return Limit(*options); }};
}

Tool MakeSnapshotTool(CLI::App& replay) {
  auto options = std::make_shared<SnapshotOptions>();
  options->run_directory = "runs/latest";
  CLI::App* app = replay.add_subcommand(
      "snapshot", "Keep a running replay as it is now, while it goes on: DIR/snapshots/shard-K/NAME");
  app->add_option("--name", options->name, "Default: the time, as automatic snapshots")->type_name("NAME");
  AddCommon(*app, options->run_directory, options->json);
  return {app, [options] { return TakeSnapshot(*options); }};
}

}  // namespace dadrl
