// What disks do to a replay: full, read-only, damaged files.
#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "tests/common/io/small_disk.h"
#include "tests/replay/service/fault_fixture.h"

namespace dadrl {
namespace {

using testing::HasSubstr;

using DiskFault = ReplayFault;

TEST_F(DiskFault, AFullFileSystemIsSaidOnceCostsNothingAndPasses) {
  const SmallDisk disk(folder_.path() / "run" / "replay", "1m");
  ASSERT_TRUE(disk.mounted()) << disk.why();
  Launch();
  AddChunks(100);
  ASSERT_TRUE(actor_->PumpUntilStored(100)) << replay_->Log();
  disk.Fill();
  AddChunks(2900);
  ASSERT_TRUE(Eventually([&] {
    actor_->Pump();
    return replay_->Log().find("actors keep their experience") != std::string::npos;
  })) << replay_->Log();
  EXPECT_THAT(replay_->Log(), HasSubstr((Shard() / "segment-").string()));
  EXPECT_THAT(replay_->Log(), HasSubstr("free some disk space"));
  const uint64_t stored = actor_->stored();
  ASSERT_LT(stored, 3000u);
  EXPECT_FALSE(learner_->Fetch(16).bytes.empty()) << "what is stored can still be sampled";

  // Killed and started again while the disk is as full as before.
  replay_->Kill();
  ASSERT_TRUE(learner_->WaitForNoReplay());
  disk.Fill();
  replay_->Start();
  ASSERT_TRUE(learner_->WaitForReplay()) << replay_->Log();
  EXPECT_FALSE(learner_->Fetch(16).bytes.empty()) << "what was acknowledged is there\n" << replay_->Log();
  EXPECT_THAT(replay_->Log(), HasSubstr("a restart would begin with older counters"))
      << "it says what it cannot";
  const std::string kept = "actors keep their experience";
  ASSERT_TRUE(Eventually([&] {
    actor_->Pump();
    const std::string log = replay_->Log();
    return log.find(kept, log.find(kept) + 1) != std::string::npos;
  })) << replay_->Log();
  EXPECT_EQ(actor_->stored(), stored) << "nothing is called stored that is not";

  disk.Free();
  ASSERT_TRUE(actor_->PumpUntilStored(stored + 100)) << replay_->Log();
  EXPECT_THAT(replay_->Log(), HasSubstr("experience can be stored again"));
  replay_->Kill();
  const auto chunks = ReadStoredChunks(Shard(), SchemaHash(kTestSpec));
  ASSERT_TRUE(chunks) << chunks.error().message;
  ExpectStoredOnce(*chunks, *actor_, 100);
}

TEST_F(DiskFault, AReadOnlyFileSystemIsServedFromAndSaid) {
  const SmallDisk disk(folder_.path() / "run" / "replay", "16m");
  ASSERT_TRUE(disk.mounted()) << disk.why();
  Launch();
  AddChunks(20);
  ASSERT_TRUE(actor_->PumpUntilStored(20));
  ASSERT_EQ(replay_->Terminate(), 0) << replay_->Log();
  ASSERT_TRUE(learner_->WaitForNoReplay());
  ASSERT_TRUE(disk.MakeReadOnly()) << std::strerror(errno);
  replay_->Start();
  ASSERT_TRUE(learner_->WaitForReplay()) << replay_->Log();
  EXPECT_FALSE(learner_->Fetch(16).bytes.empty()) << replay_->Log();
  AddChunks(5);
  ASSERT_TRUE(Eventually([&] {
    actor_->Pump();
    return replay_->Log().find("actors keep their experience") != std::string::npos;
  })) << replay_->Log();
  EXPECT_THAT(replay_->Log(), HasSubstr("the file system is read-only: choose another folder"));
  EXPECT_THAT(replay_->Log(), HasSubstr(Shard().string()));
  EXPECT_EQ(actor_->stored(), 20u);
}

TEST_F(DiskFault, SegmentsTakeNoDescriptorsAndAFullTableOfThemIsAFaultThatPasses) {
  config_.replay.segment_bytes = 1 << 16;
  Launch();
  AddChunks(100);
  ASSERT_TRUE(actor_->PumpUntilStored(100)) << replay_->Log();
  const uint64_t before = replay_->Descriptors();
  AddChunks(2000);
  ASSERT_TRUE(actor_->PumpUntilStored(2100)) << replay_->Log();
  EXPECT_LE(replay_->Descriptors(), before + 4) << "segments, forced writes and the state at the same time";
  ASSERT_TRUE(replay_->SetDescriptorLimit(STDERR_FILENO + 1)) << "no number below it is free";
  AddChunks(1000);
  ASSERT_TRUE(Eventually([&] {
    actor_->Pump();
    return replay_->Log().find("actors keep their experience") != std::string::npos;
  })) << replay_->Log();
  EXPECT_THAT(replay_->Log(), HasSubstr("raise the limit on open files"));
  EXPECT_FALSE(learner_->Fetch(16).bytes.empty());
  ASSERT_TRUE(replay_->SetDescriptorLimit(1024));
  ASSERT_TRUE(actor_->PumpUntilStored(3100)) << replay_->Log();
  EXPECT_THAT(replay_->Log(), HasSubstr("experience can be stored again"));
}

TEST_F(DiskFault, ASegmentThatCannotBeReadAnyMoreIsLeftOutAndTheProcessLives) {
  config_.replay.segment_bytes = 1 << 16;
  config_.replay.max_times_sampled = 0;
  Launch();
  AddChunks(600);
  ASSERT_TRUE(actor_->PumpUntilStored(600)) << replay_->Log();
  std::filesystem::resize_file(Shard() / "segment-000000000001.log", 0);
  ASSERT_TRUE(Eventually([&] {
    learner_->Disturb(64);
    return replay_->Log().find("is not sampled any more") != std::string::npos;
  })) << replay_->Log();
  EXPECT_THAT(replay_->Log(), HasSubstr("cannot read " + (Shard() / "segment-000000000001.log").string()));
  AddChunks(20);
  ASSERT_TRUE(actor_->PumpUntilStored(620)) << replay_->Log();
  EXPECT_FALSE(learner_->Fetch(64).bytes.empty());
  EXPECT_EQ(replay_->Terminate(), 0) << replay_->Log();
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
