// What becomes of snapshots: `dadrl replay restore`, and which of them are removed.
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "replay/storage/snapshot_folder.h"
#include "tests/replay/run_tool.h"
#include "tests/replay/tools_fixture.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

using SnapshotTools = ToolsTest;

TEST_F(SnapshotTools, RestorePutsASnapshotInPlaceOfAStoppedReplay) {
  {
    const auto table = OpenTable();
    for (int i = 0; i < 10; ++i) Round(*table, FloatCoding::kFloat16);
    ASSERT_TRUE(table->Snapshot(SnapshotFolder(run_, 0) / "good"));
    for (int i = 0; i < 10; ++i) Round(*table, FloatCoding::kFloat16);
    const ToolOutput busy = RunTool({"restore", "--run-dir", run_.string(), "--snapshot", "good"});
    EXPECT_EQ(busy.exit_code, 1);
    EXPECT_THAT(busy.err, HasSubstr("in use"));
    EXPECT_EQ(table->stats().frames_held, 600u);
  }
  const ToolOutput restored = RunTool({"restore", "--run-dir", run_.string(), "--snapshot", "good"});
  ASSERT_EQ(restored.exit_code, 0) << restored.err;
  EXPECT_EQ(OpenTable()->stats().frames_held, 300u);
  EXPECT_EQ(nlohmann::json::parse(
                RunTool({"inspect", (run_ / "replay.replaced").string(), "--json"}).out)["transitions"],
            600);
  EXPECT_EQ(RunTool({"verify", (SnapshotFolder(run_, 0) / "good").string()}).exit_code, 0);
  const ToolOutput unknown = RunTool({"restore", "--run-dir", run_.string(), "--snapshot", "bad"});
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.err, HasSubstr("no snapshot"));
}

TEST_F(SnapshotTools, ARestoreThatWasKilledHalfWayCanBeRepeated) {
  {
    const auto table = OpenTable();
    for (int i = 0; i < 10; ++i) Round(*table, FloatCoding::kFloat16);
    ASSERT_TRUE(table->Snapshot(SnapshotFolder(run_, 0) / "good"));
    for (int i = 0; i < 10; ++i) Round(*table, FloatCoding::kFloat16);
  }
  // What is there between the two renames.
  fs::copy(run_ / "snapshots", run_ / "replay.restored", fs::copy_options::recursive);
  fs::rename(run_ / "replay", run_ / "replay.replaced");
  const ToolOutput restored = RunTool({"restore", "--run-dir", run_.string(), "--snapshot", "good"});
  ASSERT_EQ(restored.exit_code, 0) << restored.err;
  EXPECT_EQ(OpenTable()->stats().frames_held, 300u);
  const ToolOutput replaced = RunTool({"inspect", (run_ / "replay.replaced").string(), "--json"});
  EXPECT_EQ(nlohmann::json::parse(replaced.out)["transitions"], 600);
}

TEST_F(SnapshotTools, RestoreTakesNoLinksAndNoStrangeFiles) {
  const fs::path snapshot = SnapshotFolder(run_, 0) / "good";
  {
    const auto table = OpenTable();
    for (int i = 0; i < 10; ++i) Round(*table, FloatCoding::kFloat16);
    ASSERT_TRUE(table->Snapshot(snapshot));
    for (int i = 0; i < 10; ++i) Round(*table, FloatCoding::kFloat16);
  }
  const fs::path secret = folder_.path() / "secret";
  std::ofstream(secret) << "of somebody else";
  const fs::path planted = snapshot / SegmentLog::NameOf(999);
  const auto refused = [&](const char* kind) {
    const ToolOutput output = RunTool({"restore", "--run-dir", run_.string(), "--snapshot", "good"});
    EXPECT_EQ(output.exit_code, 2) << kind;
    EXPECT_THAT(output.err, HasSubstr(planted.string())) << kind;
    EXPECT_EQ(OpenTable()->stats().frames_held, 600u) << "the run is as it was";
    EXPECT_FALSE(fs::exists(run_ / "replay.restored"));
    fs::remove(planted);
  };
  fs::create_symlink(secret, planted);
  refused("link");
  ASSERT_EQ(mkfifo(planted.c_str(), 0600), 0);
  refused("FIFO");
  fs::create_directory(planted);
  refused("folder");
  std::ofstream(snapshot / "notes.txt") << "mine";
  fs::create_symlink(secret, snapshot / "link");
  ASSERT_EQ(RunTool({"restore", "--run-dir", run_.string(), "--snapshot", "good"}).exit_code, 0);
  EXPECT_EQ(OpenTable()->stats().frames_held, 300u);
  EXPECT_FALSE(fs::exists(shard_ / "notes.txt"));
  EXPECT_FALSE(fs::exists(fs::symlink_status(shard_ / "link")));
}

TEST_F(SnapshotTools, OldAutomaticSnapshotsGoAndNamedOnesStay) {
  for (const char* name : {"20260101T000000Z", "20260102T000000Z", "20260103T000000Z", "mine"}) {
    fs::create_directories(folder_.path() / name);
  }
  ASSERT_TRUE(RemoveOldSnapshots(folder_.path(), 2));
  EXPECT_FALSE(fs::exists(At("20260101T000000Z")));
  EXPECT_TRUE(fs::exists(At("20260102T000000Z")));
  EXPECT_TRUE(fs::exists(At("20260103T000000Z")));
  EXPECT_TRUE(fs::exists(At("mine")));
  EXPECT_EQ(AutomaticSnapshotName(0), "19700101T000000Z");
}

TEST_F(SnapshotTools, ASnapshotThatCannotBeRemovedWholeIsNoneAnyMore) {
  const fs::path old = folder_.path() / "20260101T000000Z";
  fs::create_directories(old / "folder");
  std::ofstream(old / "state") << "of it";
  rlimit files{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &files), 0);
  const int next = dup(STDIN_FILENO);
  close(next);
  // Enough for a folder, not for one within it.
  const rlimit few{static_cast<rlim_t>(next) + 1, files.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &few), 0);
  const Status removed = RemoveOldSnapshots(folder_.path(), 0);
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &files), 0);
  ASSERT_FALSE(removed);
  EXPECT_THAT(removed.error().message, HasSubstr(PartialSnapshot(old).string()));
  EXPECT_FALSE(fs::exists(old));
  EXPECT_TRUE(fs::exists(PartialSnapshot(old)));
  ASSERT_TRUE(RemovePartialSnapshots(folder_.path()));
  EXPECT_FALSE(fs::exists(PartialSnapshot(old)));
}

}  // namespace
}  // namespace dadrl
