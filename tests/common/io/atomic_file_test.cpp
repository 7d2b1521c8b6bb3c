#include "common/io/atomic_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <string>

#include "common/io/io_error.h"
#include "common/io/read_file.h"
#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

using testing::HasSubstr;

constexpr uint64_t kNoLimit = uint64_t{1} << 30;

int FilesIn(const std::filesystem::path& directory) {
  return static_cast<int>(std::distance(std::filesystem::directory_iterator(directory), {}));
}

TEST(AtomicFile, ReplacesTheEarlierFileOnlyAtCommit) {
  TemporaryFolder folder;
  const auto path = folder.path() / "file";
  ASSERT_TRUE(WriteFileAtomically(path, "before"));
  auto file = AtomicFile::Create(path);
  ASSERT_TRUE(file);
  ASSERT_TRUE(file->Append(std::as_bytes(std::span(std::string_view("after")))));
  EXPECT_EQ(ReadTextFile(path, kNoLimit).value(), "before");
  ASSERT_TRUE(file->Commit());
  EXPECT_EQ(ReadTextFile(path, kNoLimit).value(), "after");
  EXPECT_EQ(FilesIn(folder.path()), 1);
}

TEST(AtomicFile, LeavesNothingBehindWhenAbandoned) {
  TemporaryFolder folder;
  {
    auto file = AtomicFile::Create(folder.path() / "file");
    ASSERT_TRUE(file);
    ASSERT_TRUE(file->Append(std::as_bytes(std::span(std::string_view("half")))));
  }
  EXPECT_EQ(FilesIn(folder.path()), 0);
}

TEST(AtomicFile, MissingFolderIsNotFoundAndNamed) {
  TemporaryFolder folder;
  const auto path = folder.path() / "absent" / "file";
  const Status status = WriteFileAtomically(path, "x");
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(status.error().message, HasSubstr((folder.path() / "absent").string()));
}

TEST(AtomicFile, FullDeviceIsExhaustedWithTheRemedy) {
  const FileDescriptor file(open("/dev/full", O_WRONLY | O_CLOEXEC));
  ASSERT_TRUE(file.valid());
  const Status status = WriteAll(file, std::as_bytes(std::span(std::string_view("x"))), "/run/weights");
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kExhausted);
  EXPECT_THAT(status.error().message, HasSubstr("/run/weights"));
  EXPECT_THAT(status.error().message, HasSubstr("free some disk space"));
}

// The limit on file size fails a write in the middle, as a full disk does.
TEST(AtomicFile, WriteThatFailsInTheMiddleKeepsTheEarlierFile) {
  TemporaryFolder folder;
  const auto path = folder.path() / "file";
  ASSERT_TRUE(WriteFileAtomically(path, "before"));
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{4096, 4096};
    setrlimit(RLIMIT_FSIZE, &limit);
    const Status status = WriteFileAtomically(path, std::string(100000, 'x'));
    _exit(!status && status.error().code == ErrorCode::kExhausted ? 0 : 1);
  }
  int result = 0;
  ASSERT_EQ(waitpid(child, &result, 0), child);
  EXPECT_EQ(result, 0);
  EXPECT_EQ(ReadTextFile(path, kNoLimit).value(), "before");
  EXPECT_EQ(FilesIn(folder.path()), 1);
}

// A child writes versions without pause and is killed at points that differ from round to round.
TEST(AtomicFile, KilledWriterLeavesAWholeFile) {
  TemporaryFolder folder;
  const auto path = folder.path() / "file";
  constexpr size_t kSize = 200000;
  ASSERT_TRUE(WriteFileAtomically(path, std::string(kSize, 'a')));
  for (int round = 0; round < 15; ++round) {
    int ready[2];
    ASSERT_EQ(pipe(ready), 0);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      for (int i = 0;; ++i) {
        const std::string content(kSize, static_cast<char>('a' + i % 26));
        if (!WriteFileAtomically(path, content)) _exit(1);
        if (write(ready[1], "x", 1) != 1) _exit(1);
      }
    }
    close(ready[1]);
    char byte = 0;
    for (int i = 0; i < 3; ++i) ASSERT_EQ(read(ready[0], &byte, 1), 1);
    usleep(static_cast<useconds_t>(137 * round));  // somewhere inside a write, not always the same place
    kill(child, SIGKILL);
    ASSERT_EQ(waitpid(child, nullptr, 0), child);
    close(ready[0]);
    const std::string content = ReadTextFile(path, kNoLimit).value();
    ASSERT_EQ(content.size(), kSize);
    EXPECT_EQ(std::count(content.begin(), content.end(), content[0]), static_cast<long>(kSize));
  }
  RemoveLeftoverTemporaries(folder.path());
  EXPECT_EQ(FilesIn(folder.path()), 1);
}

TEST(AtomicFile, ReplacesRegularFilesOnly) {
  TemporaryFolder folder;
  ASSERT_TRUE(WriteFileAtomically(folder.path() / "theirs", "theirs"));
  std::filesystem::create_symlink(folder.path() / "theirs", folder.path() / "link");
  std::filesystem::create_directory(folder.path() / "folder");
  for (const char* name : {"link", "folder"}) {
    const Status written = WriteFileAtomically(folder.path() / name, "ours");
    ASSERT_FALSE(written) << name;
    EXPECT_THAT(written.error().message, HasSubstr("it is not replaced; name another file"));
  }
  EXPECT_THAT(WriteFileAtomically("/dev/null", "ours").error().message, HasSubstr("a device"));
  EXPECT_EQ(ReadTextFile(folder.path() / "theirs", kNoLimit).value(), "theirs");
  EXPECT_EQ(FilesIn(folder.path()), 3);
}

// Whoever guesses the next temporary names, and puts links to a file of somebody else there, gains nothing.
TEST(AtomicFile, ATemporaryNameThatIsTakenIsNotWrittenTo) {
  TemporaryFolder folder;
  ASSERT_TRUE(WriteFileAtomically(folder.path() / "theirs", "theirs"));
  for (int counter = 0; counter < 90; ++counter) {
    std::filesystem::create_symlink("theirs",
                                    folder.path() / fmt::format(".ours.{}-{}.dadrl-tmp", getpid(), counter));
  }
  ASSERT_TRUE(WriteFileAtomically(folder.path() / "ours", "ours"));
  EXPECT_EQ(ReadTextFile(folder.path() / "theirs", kNoLimit).value(), "theirs");
  EXPECT_EQ(ReadTextFile(folder.path() / "ours", kNoLimit).value(), "ours");
}

TEST(AtomicFile, SymlinkFollowsTheNewestTarget) {
  TemporaryFolder folder;
  ASSERT_TRUE(WriteFileAtomically(folder.path() / "one", "1"));
  ASSERT_TRUE(WriteFileAtomically(folder.path() / "two", "2"));
  ASSERT_TRUE(SymlinkAtomically(folder.path() / "latest", "one"));
  EXPECT_EQ(ReadTextFile(folder.path() / "latest", kNoLimit, Links::kFollow).value(), "1");
  ASSERT_TRUE(SymlinkAtomically(folder.path() / "latest", "two"));
  EXPECT_EQ(ReadTextFile(folder.path() / "latest", kNoLimit, Links::kFollow).value(), "2");
  EXPECT_EQ(FilesIn(folder.path()), 3);
}

TEST(AppendWhole, FailedAppendLeavesTheFileAsItWas) {
  TemporaryFolder folder;
  const auto path = folder.path() / "table";
  ASSERT_TRUE(WriteFileAtomically(path, "row\n"));
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{4096, 4096};
    setrlimit(RLIMIT_FSIZE, &limit);
    const auto file = FileDescriptor::Open(path, O_WRONLY | O_APPEND);
    if (!file) _exit(2);
    const std::string content(100000, 'x');
    _exit(AppendWhole(*file, std::as_bytes(std::span(content)), path) ? 1 : 0);
  }
  int result = 0;
  ASSERT_EQ(waitpid(child, &result, 0), child);
  EXPECT_EQ(result, 0);
  EXPECT_EQ(ReadTextFile(path, kNoLimit).value(), "row\n");
}

TEST(ReadFile, MissingFileIsNotFoundAndTooLongIsRefused) {
  TemporaryFolder folder;
  EXPECT_EQ(ReadFile(folder.path() / "absent", kNoLimit).error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(WriteFileAtomically(folder.path() / "file", "12345"));
  EXPECT_EQ(ReadFile(folder.path() / "file", 4).error().code, ErrorCode::kExhausted);
  EXPECT_EQ(ReadFile(folder.path() / "file", 5)->size(), 5u);
  EXPECT_THAT(ReadFile(folder.path(), kNoLimit).error().message, HasSubstr("folder"));
}

}  // namespace
}  // namespace dadrl
