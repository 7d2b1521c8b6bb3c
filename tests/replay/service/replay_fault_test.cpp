// What the world does to a replay: kill -9, slow learners, actors that have lost their mind. (Disks:
// disk_fault_test.cpp.)
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <numeric>
#include <vector>

#include "common/io/checksum.h"
#include "proto/telemetry.h"
#include "tests/paths.h"
#include "tests/replay/service/fault_fixture.h"

namespace dadrl {
namespace {

TEST_F(ReplayFault, FiftyTimesKillNineUnderLoadLosesAndRepeatsNothing) {
  constexpr int kKills = 50;
  constexpr uint64_t kIncarnation = 100;
  config_.replay.max_times_sampled = 0;
  config_.replay.segment_bytes = 1 << 16;  // so that some fall between two segments
  Launch();
  std::vector<std::unique_ptr<PeerActor>> actors;
  for (const uint32_t id : {11u, 12u, 13u}) {
    actors.push_back(std::make_unique<PeerActor>(*actor_node_, id, kIncarnation));
  }
  const auto pump = [&] {
    for (const auto& actor : actors) actor->Pump();
  };
  const auto stored = [&] {
    uint64_t sum = 0;
    for (const auto& actor : actors) sum += actor->stored();
    return sum;
  };
  Random random(20261122);
  int looks = 0;
  for (int kill = 0; kill < kKills; ++kill) {
    for (const auto& actor : actors) {
      for (int i = 0; i < 60; ++i) {
        actor->Add({.episode = actor->produced() + 1, .frames = kFrames, .end = kTerminated});
      }
    }
    const uint64_t target = stored() + random.Below(150);
    ASSERT_TRUE(Eventually([&] {
      if (++looks % 10 == 0) learner_->Disturb(16);
      pump();
      return stored() >= target;
    })) << "kill "
        << kill << "\n"
        << replay_->Log();
    // Not at the moment of an acknowledgement, but somewhere between two.
    for (uint64_t spins = random.Below(20); spins > 0; --spins) pump();
    replay_->Kill();
    replay_->Start();
  }
  for (const auto& actor : actors) {
    ASSERT_TRUE(actor->PumpUntilStored(actor->produced(), 60.0)) << replay_->Log();
  }
  replay_->Kill();
  const auto chunks = ReadStoredChunks(Shard(), SchemaHash(kTestSpec));
  ASSERT_TRUE(chunks) << chunks.error().message;
  EXPECT_EQ(chunks->size(), actors.size() * kKills * 60u);
  for (const auto& actor : actors) ExpectStoredOnce(*chunks, *actor, kIncarnation);
}

TEST_F(ReplayFault, ALearnerThatTakesNothingHoldsUpNobody) {
  config_.replay.max_times_sampled = 0;
  Launch();
  AddChunks(50);
  ASSERT_TRUE(actor_->PumpUntilStored(50));
  // More than the learner's reader (16) and the writer's cache take together.
  std::vector<uint64_t> requests;
  for (int i = 0; i < 40; ++i) requests.push_back(learner_->Ask(1024));
  // Meanwhile others store what they drive, in turns.
  constexpr uint64_t kChunks = 400;
  std::vector<std::unique_ptr<PeerActor>> actors;
  for (const uint32_t id : {11u, 12u, 13u, 14u}) {
    actors.push_back(std::make_unique<PeerActor>(*actor_node_, id, 100));
    for (uint64_t i = 0; i < kChunks; ++i) {
      actors.back()->Add({.episode = i + 1, .frames = kFrames, .end = kTerminated});
    }
  }
  const bool all_stored = Eventually([&] {
    for (const auto& actor : actors) actor->Pump();
    return std::all_of(actors.begin(), actors.end(),
                       [](const auto& actor) { return actor->stored() == kChunks; });
  });
  for (const auto& actor : actors) EXPECT_EQ(actor->stored(), kChunks) << actor->id() << replay_->Log();
  ASSERT_TRUE(all_stored);
  // The batches that wait for their learner come as soon as it takes them, each once, and the last of them
  // were not sent before all of that was stored: it did hold its replies up.
  uint64_t newest = 0;
  for (const uint64_t request : requests) {
    ASSERT_TRUE(Eventually([&] { return learner_->RepliesTo(request).size() == 1; })) << replay_->Log();
    newest = std::max(newest, learner_->RepliesTo(request)[0].frames_inserted);
  }
  EXPECT_EQ(newest, (50 + actors.size() * kChunks) * kFrames);
  EXPECT_FALSE(learner_->Fetch(32).bytes.empty()) << replay_->Log();
}

// A program of this test, by its arguments; its process id.
pid_t Spawn(const std::vector<std::string>& arguments) {
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  const pid_t pid = fork();
  if (pid != 0) return pid;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  execv(argv[0], argv.data());
  _exit(127);
}

TEST_F(ReplayFault, TwoHundredActorsJoinAtOnceAndAllTheirChunksAreThereOnce) {
  constexpr int kProcesses = 8;
  constexpr int kActors = 25;
  constexpr int kChunks = 20;
  Launch();
  std::vector<pid_t> pids;
  for (int process = 0; process < kProcesses; ++process) {
    pids.push_back(
        Spawn({std::string(DADRL_BINARY_DIR) + "/tests/many_actors",
               (folder_.path() / "run" / "config.yaml").string(), std::to_string(1 + process * kActors),
               std::to_string(kActors), std::to_string(kChunks)}));
  }
  for (const pid_t pid : pids) {
    int status = 0;
    waitpid(pid, &status, 0);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status << "\n" << replay_->Log();
  }
  replay_->Kill();
  const auto chunks = ReadStoredChunks(Shard(), SchemaHash(kTestSpec));
  ASSERT_TRUE(chunks) << chunks.error().message;
  EXPECT_EQ(chunks->size(), static_cast<size_t>(kProcesses * kActors * kChunks));
  for (const auto& [identity, copies] : *chunks) EXPECT_EQ(copies.size(), 1u) << identity.actor;
}

// What the replay tells the monitor.
std::optional<ProcessStatus> NextStatus(TelemetrySubscriber& telemetry) {
  std::optional<ProcessStatus> last;
  telemetry.Poll(std::chrono::milliseconds(100), [&](const ProcessStatus& status) { last = status; }, {});
  return last;
}

double AllRejected(const ProcessStatus& status) {
  return std::accumulate(&status.metrics[static_cast<size_t>(Metric::kRejectedGarbage)],
                         &status.metrics[static_cast<size_t>(Metric::kRejectedStale)] + 1, 0.0);
}

TEST_F(ReplayFault, WhatAnInsaneActorSendsIsCountedAndChangesNothing) {
  config_.telemetry.interval_s = 0.1;
  const auto telemetry = TelemetrySubscriber::Create(TelemetryUrl(config_.cluster));
  ASSERT_TRUE(telemetry) << telemetry.error().message;
  Launch();
  AddChunks(10);
  ASSERT_TRUE(actor_->PumpUntilStored(10));

  const auto with_checksum = [](std::vector<std::byte> bytes) {
    const uint64_t checksum = Xxh3(std::span(bytes).first(bytes.size() - 8));
    std::memcpy(&bytes[bytes.size() - 8], &checksum, 8);
    return bytes;
  };
  const auto changed = [&](size_t at, uint32_t value) {
    std::vector<std::byte> bytes = Build({.identity = {1, 100, 11}});
    std::memcpy(&bytes[at], &value, sizeof(value));
    return with_checksum(bytes);
  };
  std::vector<std::byte> shorter = Build({.identity = {1, 100, 11}});
  shorter.resize(shorter.size() - 9);
  std::vector<std::vector<std::byte>> rejected = {
      std::vector<std::byte>(5000, std::byte{0x5a}),  // garbage
      {},
      std::vector<std::byte>(size_t{4} << 20, std::byte{0}),  // the largest that the topic lets through
      changed(4, 999),                                        // of another version
      changed(16, 0),                                         // no frames
      changed(16, 0xffffffff),                                // too many
      changed(20, 0x7fffffff),                                // payloads beyond the end
      with_checksum(shorter),
  };
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    std::vector<std::byte> bytes = Build({.identity = {1, 100, 11}});
    bytes[random.Below(bytes.size())] ^= static_cast<std::byte>(1 + random.Below(255));
    rejected.push_back(std::move(bytes));
  }
  std::vector<std::vector<std::byte>> duplicates;
  for (uint64_t sequence = 1; sequence <= 10; ++sequence) duplicates.push_back(actor_->chunk(sequence));
  for (auto& bytes : rejected) {
    ASSERT_TRUE(Eventually([&] { return actor_->Send(bytes, 1); })) << replay_->Log();
  }
  for (auto& bytes : duplicates) ASSERT_TRUE(Eventually([&] { return actor_->Send(bytes, 1); }));

  std::optional<ProcessStatus> status;
  EXPECT_TRUE(Eventually([&] {
    if (const auto next = NextStatus(**telemetry)) status = next;
    return status && AllRejected(*status) >= static_cast<double>(rejected.size()) &&
           (*status)[Metric::kDuplicateChunks] >= static_cast<double>(duplicates.size());
  })) << (status ? AllRejected(*status) : -1.0)
      << replay_->Log();
  EXPECT_EQ(AllRejected(*status), static_cast<double>(rejected.size()));
  // Every kind that bytes alone can be.
  for (const Metric kind : {Metric::kRejectedGarbage, Metric::kRejectedVersion, Metric::kRejectedLength,
                            Metric::kRejectedChecksum}) {
    EXPECT_GT((*status)[kind], 0.0) << MetricName(kind);
  }
  EXPECT_EQ((*status)[Metric::kFramesHeld], 10.0 * kFrames);

  learner_->Fetch(4);
  EXPECT_TRUE(Eventually([&] {
    learner_->SetPriority(1, -1.0F);
    if (const auto next = NextStatus(**telemetry)) status = next;
    return (*status)[Metric::kRefusedPriorities] > 0.0;
  })) << replay_->Log();

  AddChunks(10);
  ASSERT_TRUE(actor_->PumpUntilStored(20)) << replay_->Log();
  replay_->Kill();
  const auto chunks = ReadStoredChunks(Shard(), SchemaHash(kTestSpec));
  ASSERT_TRUE(chunks) << chunks.error().message;
  EXPECT_EQ(chunks->size(), 20u);
  ExpectStoredOnce(*chunks, *actor_, 100);
}

}  // namespace
}  // namespace dadrl
