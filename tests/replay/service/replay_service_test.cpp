// The replay process with its neighbours over real DDS on loopback.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <map>
#include <utility>

#include "common/config/config_yaml.h"
#include "common/io/checksum.h"
#include "proto/telemetry.h"
#include "proto/telemetry_packet.h"
#include "tests/replay/service/service_fixture.h"

namespace dadrl {
namespace {

TEST_F(ReplayServiceTest, StoresAcknowledgesAndServes) {
  Launch();
  AddChunks(50);
  ASSERT_TRUE(actor_->PumpUntilStored(50)) << replay_->Log();
  const auto reply = learner_->Fetch(32);
  TrajectoryBatch batch(kTestSpec, {32});
  ASSERT_TRUE(TrajectoryDecoder(kTestSpec, kTestBounds).Decode(reply.bytes, batch));
  EXPECT_EQ(reply.frames_inserted, 50u * kFrames);
  for (size_t i = 0; i < 32; ++i) EXPECT_EQ(EgoOf(batch.observations)[i * 20 + 1], batch.rewards[i]);
}

TEST_F(ReplayServiceTest, EveryAcknowledgedFrameIsThereOnceAfterKillNine) {
  Launch();
  Random random(1);
  for (int round = 0; round < 6; ++round) {
    AddChunks(60);
    // Killed in the middle of it, at another place each time.
    const uint64_t target = actor_->stored() + 1 + random.Below(40);
    ASSERT_TRUE(actor_->PumpUntilStored(target)) << replay_->Log();
    replay_->Kill();
    replay_->Start();
  }
  ASSERT_TRUE(actor_->PumpUntilStored(actor_->produced(), 60.0)) << replay_->Log();
  replay_->Kill();
  ASSERT_TRUE(learner_->WaitForNoReplay());
  replay_->Start();
  ASSERT_TRUE(learner_->WaitForReplay());
  const auto counts = SampleAll();
  EXPECT_EQ(counts.size(), actor_->produced() * kFrames);
  for (const auto& [reward, count] : counts) EXPECT_EQ(count, 1) << reward;
}

TEST_F(ReplayServiceTest, ARequestWaitsInsideUntilThereIsEnough) {
  Launch();
  const uint64_t number = learner_->Ask(4);
  ASSERT_TRUE(Eventually([&] { return learner_->RepliesTo(number).size() == 1; })) << replay_->Log();
  EXPECT_TRUE(learner_->RepliesTo(number)[0].bytes.empty()) << "it is told that it waits";
  learner_->Ask(4, number);
  ASSERT_TRUE(Eventually([&] { return learner_->RepliesTo(number).size() == 2; }));
  EXPECT_TRUE(learner_->RepliesTo(number)[1].bytes.empty());
  AddChunks(10);
  ASSERT_TRUE(actor_->PumpUntilStored(10));
  ASSERT_TRUE(Eventually([&] { return learner_->RepliesTo(number).size() == 3; }));
  EXPECT_FALSE(learner_->RepliesTo(number)[2].bytes.empty());
}

TEST_F(ReplayServiceTest, ItListensWhileManyRequestsWait) {
  Launch();
  std::vector<uint64_t> asked;
  for (int i = 0; i < 16; ++i) asked.push_back(learner_->Ask(4));
  ASSERT_TRUE(Eventually([&] { return learner_->RepliesTo(asked.back()).size() == 1; })) << replay_->Log();
  learner_->Ask(4, asked.front());
  EXPECT_TRUE(Eventually([&] { return learner_->RepliesTo(asked.front()).size() == 2; })) << replay_->Log();
}

TEST_F(ReplayServiceTest, EveryRequestIsAnsweredOnceBatchesLargeAndSmall) {
  config_.replay.max_times_sampled = 0;
  Launch();
  AddChunks(50);
  ASSERT_TRUE(actor_->PumpUntilStored(50)) << replay_->Log();
  std::vector<uint64_t> asked;
  std::vector<uint64_t> repeated;
  for (int round = 0; round < 20; ++round) {
    // Large and small in turn, so that one that is sampled later is read sooner.
    for (int i = 0; i < 10; ++i) asked.push_back(learner_->Ask(i % 2 == 0 ? 500 : 1));
    repeated.push_back(learner_->Ask(500, asked[asked.size() - 2]));
    ASSERT_TRUE(Eventually([&] {
      return std::all_of(asked.begin(), asked.end(),
                         [&](uint64_t number) { return !learner_->RepliesTo(number).empty(); });
    })) << replay_->Log();
  }
  std::map<uint64_t, int> times;
  for (const uint64_t number : learner_->batches()) ++times[number];
  ASSERT_EQ(times.size(), asked.size());
  // One that was sent before it was asked for again is sampled again.
  for (const uint64_t number : repeated) EXPECT_LE(std::exchange(times[number], 1), 2) << number;
  for (const auto& [number, count] : times) EXPECT_EQ(count, 1) << number;
}

TEST_F(ReplayServiceTest, ANewLearnerIsServedWhenTheOldOneLeavesItsBatchesUntaken) {
  config_.replay.max_times_sampled = 0;
  Launch();
  AddChunks(50);
  ASSERT_TRUE(actor_->PumpUntilStored(50)) << replay_->Log();
  // More than its reader (16) and the writer's cache take together: a batch is stuck half way.
  for (int i = 0; i < 40; ++i) learner_->Ask(1024);
  learner_.reset();
  learner_ = std::make_unique<PeerLearner>(*learner_node_, 201, 1);
  ASSERT_TRUE(learner_->WaitForReplay());
  EXPECT_FALSE(learner_->Fetch(32).bytes.empty()) << replay_->Log();
}

TEST_F(ReplayServiceTest, ActorsAreHeldBackUntilTheLearnerCatchesUp) {
  config_.replay.min_size = 8;
  config_.replay.max_times_sampled = 0;
  config_.replay.min_samples_per_insert = 0.5;
  config_.replay.samples_per_insert_band = 1.0;
  Launch();
  AddChunks(200);
  ASSERT_TRUE(Eventually([&] {
    actor_->Pump();
    return actor_->stored() >= 4 && actor_->granted() == actor_->stored();
  })) << replay_->Log();
  const uint64_t held_at = actor_->stored();
  EXPECT_LT(held_at, 20u);
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(learner_->Fetch(4).bytes.empty());
  EXPECT_TRUE(actor_->PumpUntilStored(held_at + 1)) << replay_->Log();
}

TEST_F(ReplayServiceTest, DuplicatesGarbageAndGapsChangeNothing) {
  Launch();
  AddChunks(4);
  ASSERT_TRUE(actor_->PumpUntilStored(4));
  std::vector<std::byte> garbage(5000, std::byte{0x5a});
  std::vector<std::byte> nothing;
  TestChunk repeated{.identity = {1, 100, 2}, .episode = 9, .frames = kFrames};
  TestChunk far_ahead{.identity = {1, 100, 9}, .episode = 9, .frames = kFrames};
  std::vector<std::byte> duplicate = Build(repeated);
  std::vector<std::byte> gap = Build(far_ahead);
  for (auto* bytes : {&garbage, &nothing, &duplicate, &gap}) ASSERT_TRUE(actor_->Send(*bytes, 1));
  AddChunks(6);
  ASSERT_TRUE(actor_->PumpUntilStored(10)) << replay_->Log();
  const auto counts = SampleAll();
  EXPECT_EQ(counts.size(), 40u);
  for (const auto& [reward, count] : counts) EXPECT_LT(reward, TestReward(1, 6, 0));
}

TEST_F(ReplayServiceTest, EveryKindOfBadChunkIsRefusedByNameAndTheNextIsTaken) {
  config_.replay.verify_frames = VerifyFrames::kAll;
  Launch();
  const auto bad = [&](ChunkFault fault, const char* why, std::vector<std::byte> bytes) {
    AddChunks(1);
    actor_->AddRaw(std::move(bytes));
    const uint64_t refused = actor_->refused();
    ASSERT_TRUE(actor_->PumpUntilStored(actor_->produced())) << why << replay_->Log();
    ASSERT_TRUE(Eventually([&] { return actor_->Pump(), actor_->refused() == refused + 1; })) << why;
    EXPECT_EQ(actor_->refusal().first, fault) << why;
    EXPECT_THAT(actor_->refusal().second, testing::HasSubstr(why));
  };
  const auto chunk = [&] { return Build({.identity = {1, 100, actor_->produced() + 2}, .episode = 900}); };
  const auto changed = [&](size_t at, uint32_t value) {
    std::vector<std::byte> bytes = chunk();
    std::memcpy(&bytes[at], &value, sizeof(value));
    const uint64_t checksum = Xxh3(std::span(bytes).first(bytes.size() - 8));
    std::memcpy(&bytes[bytes.size() - 8], &checksum, 8);
    return bytes;
  };
  bad(ChunkFault::kGarbage, "magic", std::vector<std::byte>(500, std::byte{0x5a}));
  bad(ChunkFault::kVersion, "version 999", changed(4, 999));
  bad(ChunkFault::kLength, "0 frames", changed(16, 0));
  std::vector<std::byte> flipped = chunk();
  flipped[100] ^= std::byte{1};
  bad(ChunkFault::kChecksum, "checksum", flipped);
  bad(ChunkFault::kSchema, "schema", changed(48, 12345));
  bad(ChunkFault::kContents, "finite", changed(kChunkHeaderBytes + 4 * kFrames, 0x7fc00000));
  AddChunks(1);
  ASSERT_TRUE(actor_->PumpUntilStored(actor_->produced())) << replay_->Log();
  EXPECT_EQ(learner_->Fetch(1).frames_inserted, 7u * kFrames) << "all that was sound";
}

TEST_F(ReplayServiceTest, TellsWhoJoinsTheConfigurationOfTheRun) {
  Launch();
  const auto reader = Reader<dadrl_idl_RunConfig>::Create(*actor_node_, kRunConfigTopic).value();
  std::string yaml;
  ASSERT_TRUE(Eventually([&] {
    return reader->Take(1, [&](const dadrl_idl_RunConfig& message) {
      yaml.assign(reinterpret_cast<const char*>(message.yaml._buffer), message.yaml._length);
    }) > 0;
  })) << replay_->Log();
  EXPECT_EQ(yaml, ToYaml(config_, false));
}

TEST_F(ReplayServiceTest, PassesOnTheTelemetryThatLcmDoesNotReach) {
  const auto local = TelemetrySubscriber::Create(TelemetryUrl(config_.cluster));
  Launch();
  const auto elsewhere = TelemetrySubscriber::CreateRelayed(config_, kTestRunKey).value();
  const auto writer = Writer<dadrl_idl_Telemetry>::Create(*actor_node_, kTelemetryTopic).value();
  const auto send = [&](bool is_episode, std::vector<std::byte> packet) {
    dadrl_idl_Telemetry message{};
    message.is_episode = is_episode;
    message.packet._buffer = reinterpret_cast<uint8_t*>(packet.data());
    message.packet._length = message.packet._maximum = static_cast<uint32_t>(packet.size());
    EXPECT_TRUE(writer->Write(message));
  };
  ProcessStatus status;
  status.index = 77;
  EpisodeReport report;
  report.scenario = "seventy_eight";
  // Lossy: again, until it was heard.
  const auto hears = [&](TelemetrySubscriber& subscriber) {
    bool status_heard = false;
    bool report_heard = false;
    return Eventually([&] {
      send(false, std::vector<std::byte>(300, std::byte{0x5a}));
      send(true, EncodePacket(status));
      send(false, EncodePacket(status));
      send(true, EncodePacket(report));
      subscriber.Poll(
          std::chrono::milliseconds(50),
          [&](const ProcessStatus& heard) { status_heard |= heard.index == status.index; },
          [&](const EpisodeReport& heard) { report_heard |= heard.scenario == report.scenario; });
      return status_heard && report_heard;
    });
  };
  EXPECT_TRUE(hears(*elsewhere)) << replay_->Log();
  EXPECT_TRUE(elsewhere->refusals().empty()) << "forged packets are not passed on";
  if (local) {
    EXPECT_TRUE(hears(**local)) << replay_->Log();
  }
}

TEST_F(ReplayServiceTest, SigtermDrainsAndTheNextRunGoesOnCounting) {
  Launch();
  AddChunks(20);
  ASSERT_TRUE(actor_->PumpUntilStored(20));
  EXPECT_FALSE(learner_->Fetch(16).bytes.empty());
  EXPECT_EQ(replay_->Terminate(), 0) << replay_->Log();
  replay_->Start();
  ASSERT_TRUE(Eventually([&] { return actor_->connected(); }));
  ASSERT_TRUE(learner_->WaitForReplay());
  AddChunks(1);
  ASSERT_TRUE(actor_->PumpUntilStored(21)) << replay_->Log();
  EXPECT_EQ(learner_->Fetch(1).frames_inserted, 21u * kFrames);
}

TEST_F(ReplayServiceTest, AFullDiskStopsAcknowledgementsNotSamplesAndIsOverWhenThereIsRoom) {
  Launch(/*file_limit=*/30000);
  AddChunks(400);
  ASSERT_TRUE(Eventually([&] {
    actor_->Pump();
    return replay_->Log().find("actors keep their experience") != std::string::npos;
  })) << replay_->Log();
  const uint64_t stored = actor_->stored();
  EXPECT_LT(stored, 400u);
  EXPECT_FALSE(learner_->Fetch(16).bytes.empty());
  replay_->SetFileLimit(RLIM_INFINITY);
  ASSERT_TRUE(actor_->PumpUntilStored(400)) << replay_->Log();
  EXPECT_THAT(replay_->Log(), testing::HasSubstr("can be stored again"));
}

TEST_F(ReplayServiceTest, AReplayThatLostEverythingTakesActorsWhereTheyAre) {
  Launch();
  AddChunks(10);
  ASSERT_TRUE(actor_->PumpUntilStored(10));
  replay_->Kill();
  std::filesystem::remove_all(folder_.path() / "run" / "replay");
  replay_->Start();
  AddChunks(10);
  ASSERT_TRUE(actor_->PumpUntilStored(20)) << replay_->Log();
  EXPECT_EQ(learner_->Fetch(1).frames_inserted, 10u * kFrames);
}

TEST_F(ReplayServiceTest, EveryWayNotToStartIsOneLineAndAnExitCode) {
  Launch();
  const auto fails = [&](const std::filesystem::path& run, const Config& config, int code, const char* says) {
    ReplayProcess second(run, config);
    second.Start();
    EXPECT_EQ(second.WaitForExit(), code);
    const std::string log = second.Log();
    EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 1) << log;
    EXPECT_THAT(log, testing::HasSubstr(says));
  };
  fails(folder_.path() / "other", config_, 1, "port");
  AddChunks(2);
  ASSERT_TRUE(actor_->PumpUntilStored(2));
  replay_->Kill();
  Config other = config_;
  other.observation.vehicles = 3;
  std::filesystem::create_directories(folder_.path() / "foreign");
  std::filesystem::copy(folder_.path() / "run" / "replay", folder_.path() / "foreign" / "replay",
                        std::filesystem::copy_options::recursive);
  fails(folder_.path() / "foreign", other, 1, "schema");
  std::filesystem::create_directories(folder_.path() / "blocked");
  std::ofstream(folder_.path() / "blocked" / "replay") << "a file where a folder should be";
  fails(folder_.path() / "blocked", config_, 1, "replay");
  other = config_;
  other.replay.sampler = SamplerKind::kNewestFirst;
  other.replay.max_times_sampled = 0;
  fails(folder_.path() / "unset", other, 2, "replay.max_times_sampled");
}

}  // namespace
}  // namespace dadrl
