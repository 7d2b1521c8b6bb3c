#include "deploy/local/run_directory.h"

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/config/config_yaml.h"
#include "tests/deploy/local/test_processes.h"

namespace dadrl {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

namespace fs = std::filesystem;

TEST(RunDirectory, CreatesItsFoldersAndKeepsTheConfiguration) {
  const TemporaryFolder folder;
  const fs::path root = folder.path() / "a/run";
  const auto run = RunDirectory::CreateNew(root);
  ASSERT_TRUE(run) << run.error().message;
  for (const char* name : {"checkpoints", "replay", "logs", "tensorboard"})
    EXPECT_TRUE(fs::is_directory(root / name));
  Config config;
  config.seed = 77;
  ASSERT_TRUE(run->SaveConfig(config));
  Config loaded;
  ASSERT_TRUE(LoadYaml(root / "config.yaml", loaded));
  EXPECT_EQ(loaded.seed, 77u);
}

TEST(RunDirectory, RefusesASecondLauncherAndNamesTheFirst) {
  const TemporaryFolder folder;
  const auto first = RunDirectory::CreateNew(folder.path());
  ASSERT_TRUE(first);
  EXPECT_TRUE(IsRunning(first->paths()));
  const auto second = RunDirectory::CreateNew(folder.path());
  ASSERT_FALSE(second);
  EXPECT_EQ(ExitCode(second.error()), 1);
  EXPECT_THAT(second.error().message,
              HasSubstr("in use by another dadrl (process " + std::to_string(getpid())));
}

TEST(RunDirectory, RefusesToStartOverAnExistingRunUnlessItResumes) {
  const TemporaryFolder folder;
  {
    const auto run = RunDirectory::CreateNew(folder.path());
    ASSERT_TRUE(run);
    ASSERT_TRUE(run->SaveConfig(Config{}));
  }
  EXPECT_FALSE(IsRunning(RunPaths{folder.path()}));
  const auto again = RunDirectory::CreateNew(folder.path());
  ASSERT_FALSE(again);
  EXPECT_EQ(ExitCode(again.error()), 2);
  EXPECT_THAT(again.error().message, HasSubstr("--resume"));
  EXPECT_TRUE(RunDirectory::OpenExisting(folder.path()));
}

TEST(RunDirectory, RefusesToResumeNothing) {
  const TemporaryFolder folder;
  const auto run = RunDirectory::OpenExisting(folder.path() / "missing");
  ASSERT_FALSE(run);
  EXPECT_EQ(run.error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(fs::exists(folder.path() / "missing"));
}

TEST(RunDirectory, RefusesAFileAsDirectory) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "file") << "x";
  EXPECT_FALSE(RunDirectory::CreateNew(folder.path() / "file"));
}

TEST(RunDirectory, ALockThatIsSomebodyElsesFileIsNotWrittenTo) {
  const TemporaryFolder folder;
  const fs::path theirs = folder.path() / "theirs";
  const fs::path lock = folder.path() / "run/lock";
  std::ofstream(theirs) << "theirs";
  fs::create_directories(folder.path() / "run");
  fs::create_symlink(theirs, lock);
  EXPECT_THAT(RunDirectory::CreateNew(folder.path() / "run").error().message, HasSubstr("is a link"));
  fs::remove(lock);
  fs::create_hard_link(theirs, lock);
  EXPECT_THAT(RunDirectory::CreateNew(folder.path() / "run").error().message,
              HasSubstr("copy it with cp -a"));
  EXPECT_EQ(FileText(theirs), "theirs");
}

TEST(RunDirectory, AConfigurationThatIsALinkIsNotRead) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "theirs") << "seed: 3\n";
  fs::create_symlink(folder.path() / "theirs", folder.path() / "config.yaml");
  Config config;
  const Status loaded = LoadRunConfig(RunPaths{folder.path()}, config);
  ASSERT_FALSE(loaded);
  EXPECT_THAT(loaded.error().message, HasSubstr("is a link"));
}

TEST(RunDirectory, TakesOverFromAKilledLauncher) {
  const TemporaryFolder folder;
  const fs::path locked = folder.path() / "locked";
  const pid_t launcher = fork();
  if (launcher == 0) {
    const auto run = RunDirectory::CreateNew(folder.path() / "run");
    if (run && run->SaveConfig(Config{})) std::ofstream(locked) << "yes";
    pause();
    _exit(0);
  }
  ASSERT_TRUE(Eventually([&] { return fs::exists(locked); }));
  EXPECT_FALSE(RunDirectory::OpenExisting(folder.path() / "run"));
  kill(launcher, SIGKILL);
  waitpid(launcher, nullptr, 0);
  EXPECT_TRUE(fs::exists(folder.path() / "run/lock"));  // stale, and no obstacle
  EXPECT_TRUE(RunDirectory::OpenExisting(folder.path() / "run"));
}

TEST(RunDirectory, StaysLockedByTheProgramThatItsHolderBecomes) {
  const TemporaryFolder folder;
  const fs::path root = folder.path() / "run";
  const pid_t launcher = fork();
  if (launcher == 0) {
    const auto run = RunDirectory::CreateNew(root);
    if (!run) _exit(1);
    run->KeepAcrossExec();
    execlp("sh", "sh", "-c", ": > \"$0\"; exec sleep 1000", (folder.path() / "replaced").c_str(),
           static_cast<char*>(nullptr));
    _exit(1);
  }
  ASSERT_TRUE(Eventually([&] { return fs::exists(folder.path() / "replaced"); }));
  EXPECT_TRUE(IsRunning({.root = root}));
  kill(launcher, SIGKILL);
  waitpid(launcher, nullptr, 0);
  EXPECT_FALSE(IsRunning({.root = root}));
}

TEST(RunDirectory, NamesNewRunsByScenarioAndTimeWithoutClashes) {
  const TemporaryFolder folder;
  const fs::path first = NewRunPath(folder.path(), "left_turn");
  EXPECT_THAT(first.filename().string(), StartsWith("left_turn-2"));
  fs::create_directories(first);
  EXPECT_FALSE(fs::exists(NewRunPath(folder.path(), "left_turn")));
}

TEST(RunDirectory, LatestFollowsTheNewestRunAndSparesWhatIsNotALink) {
  const TemporaryFolder folder;
  for (const char* name : {"one", "two"}) {
    fs::create_directories(folder.path() / name);
    LinkLatest(folder.path() / name);
    EXPECT_EQ(fs::read_symlink(folder.path() / "latest"), name);
  }
  fs::remove(folder.path() / "latest");
  fs::create_directories(folder.path() / "latest");
  LinkLatest(folder.path() / "one");
  EXPECT_FALSE(fs::is_symlink(folder.path() / "latest"));
}

}  // namespace
}  // namespace dadrl
