#include <cstdio>
#include <memory>
#include <string>

#include "common/io/link_file.h"
#include "replay/storage/snapshot_restore.h"
#include "replay/tools/tool.h"

namespace dadrl {
namespace {

struct Options {
  std::string run_directory;
  std::string snapshot;
};

Result<int> Restore(const Options& options) {
  const std::filesystem::path run = FollowLinks(options.run_directory);
  DADRL_RETURN_IF_ERROR(RestoreSnapshot(run, options.snapshot));
  fmt::print(stderr, "{} is snapshot {} now; what it was is in {}\n", (run / "replay").string(),
             options.snapshot, ReplacedReplay(run).string());
  return 0;
}

}  // namespace

Tool MakeRestoreTool(CLI::App& replay) {
  auto options = std::make_shared<Options>();
  CLI::App* app = replay.add_subcommand("restore", "Put a snapshot in place of a stopped run's experience");
  app->add_option("--run-dir", options->run_directory, "The run")->required()->type_name("DIR");
  app->add_option("--snapshot", options->snapshot, "Name of the snapshot, as in DIR/snapshots/shard-K/")
      ->required()
      ->type_name("NAME");
  return {app, [options] { return Restore(*options); }};
}

}  // namespace dadrl
