// What disks do to a replay: full, read-only, damaged files.
#include <gmock/gmock.h>
#include <sys/mount.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "tests/replay/service/fault_fixture.h"

namespace dadrl {
namespace {

using testing::HasSubstr;

using DiskFault = ReplayFault;

// A file system of its own, this small. Only root may mount one.
class TinyDisk {
 public:
  TinyDisk(const std::filesystem::path& at, const char* size) : at_(at) {
    std::filesystem::create_directories(at_);
    mounted_ = mount("tmpfs", at_.c_str(), "tmpfs", 0, fmt::format("size={}", size).c_str()) == 0;
    error_ = errno;
  }
  ~TinyDisk() {
    if (mounted_) umount2(at_.c_str(), MNT_DETACH);
  }
  TinyDisk(const TinyDisk&) = delete;
  TinyDisk& operator=(const TinyDisk&) = delete;
  bool mounted() const { return mounted_; }
  std::string why() const { return std::strerror(error_); }
  bool MakeReadOnly() { return mount(nullptr, at_.c_str(), nullptr, MS_REMOUNT | MS_RDONLY, nullptr) == 0; }

 private:
  std::filesystem::path at_;
  bool mounted_ = false;
  int error_ = 0;
};

TEST_F(DiskFault, AFullFileSystemIsSaidOnceCostsNothingAndPasses) {
  if (geteuid() != 0) GTEST_SKIP() << "only root may mount a small file system";
  const TinyDisk disk(folder_.path() / "run" / "replay", "1m");
  ASSERT_TRUE(disk.mounted()) << disk.why();
  const auto filler = folder_.path() / "run" / "replay" / "filler";
  std::ofstream(filler) << std::string(900 << 10, 'x');
  Launch();
  AddChunks(3000);
  ASSERT_TRUE(Eventually([&] {
    actor_->Pump();
    return replay_->Log().find("actors keep their experience") != std::string::npos;
  })) << replay_->Log();
  EXPECT_THAT(replay_->Log(), HasSubstr((Shard() / "segment-").string()));
  EXPECT_THAT(replay_->Log(), HasSubstr("free some disk space"));
  const uint64_t stored = actor_->stored();
  ASSERT_LT(stored, 3000u);
  EXPECT_FALSE(learner_->Fetch(16).bytes.empty()) << "what is stored can still be sampled";
  // What was acknowledged survives a death on the full disk.
  replay_->Kill();
  std::filesystem::remove(filler);
  replay_->Start();
  ASSERT_TRUE(actor_->PumpUntilStored(stored + 100)) << replay_->Log();
  replay_->Kill();
  const auto chunks = ReadStoredChunks(Shard(), SchemaHash(kTestSpec));
  ASSERT_TRUE(chunks) << chunks.error().message;
  ExpectStoredOnce(*chunks, *actor_, 100);
}

TEST_F(DiskFault, AReadOnlyFolderIsOneLineAtTheStartAndTouchesNothing) {
  if (geteuid() != 0) GTEST_SKIP() << "only root may mount a read-only file system";
  TinyDisk disk(folder_.path() / "run" / "replay", "16m");
  ASSERT_TRUE(disk.mounted()) << disk.why();
  Launch();
  AddChunks(20);
  ASSERT_TRUE(actor_->PumpUntilStored(20));
  ASSERT_EQ(replay_->Terminate(), 0) << replay_->Log();
  ASSERT_TRUE(disk.MakeReadOnly()) << std::strerror(errno);
  const std::string before = replay_->Log();
  replay_->Start();
  EXPECT_EQ(replay_->WaitForExit(), 1);
  const std::string log = replay_->Log().substr(before.size());
  EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 1) << log;
  EXPECT_THAT(log, HasSubstr("the file system is read-only: choose another folder"));
  EXPECT_THAT(log, HasSubstr(Shard().string()));
}

TEST_F(DiskFault, DamagedFilesCostWhatWasDamagedAndServiceGoesOn) {
  config_.replay.segment_bytes = 1 << 16;
  Launch();
  AddChunks(600);
  ASSERT_TRUE(actor_->PumpUntilStored(600)) << replay_->Log();
  replay_->Kill();
  Random random(7);
  for (int round = 0; round < 3; ++round) {
    ASSERT_TRUE(learner_->WaitForNoReplay());
    std::vector<std::filesystem::path> segments;
    for (const auto& entry : std::filesystem::directory_iterator(Shard())) {
      if (entry.path().filename().string().starts_with("segment-")) segments.push_back(entry.path());
    }
    ASSERT_FALSE(segments.empty());
    const auto& victim = segments[random.Below(segments.size())];
    std::fstream file(victim, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(random.Below(std::filesystem::file_size(victim))));
    file.put('\x5a');
    file.close();
    std::filesystem::resize_file(segments.back(), std::filesystem::file_size(segments.back()) - 1);
    replay_->Start();
    ASSERT_TRUE(learner_->WaitForReplay()) << replay_->Log();
    AddChunks(20);
    ASSERT_TRUE(actor_->PumpUntilStored(actor_->produced())) << replay_->Log();
    ASSERT_FALSE(learner_->Fetch(16).bytes.empty()) << replay_->Log();
    replay_->Kill();
  }
  EXPECT_THAT(replay_->Log(), HasSubstr("damaged or torn bytes"));
  const auto chunks = ReadStoredChunks(Shard(), SchemaHash(kTestSpec));
  ASSERT_TRUE(chunks) << chunks.error().message;
  EXPECT_GE(chunks->size(), 660u - 6u) << "each round damaged two records at most";
  for (const auto& [identity, copies] : *chunks) {
    EXPECT_EQ(copies.size(), 1u);
    EXPECT_EQ(copies[0], actor_->chunk(identity.sequence));
  }
}

}  // namespace
}  // namespace dadrl
