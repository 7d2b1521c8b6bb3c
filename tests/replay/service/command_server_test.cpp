// A maintenance whose disk takes for ever holds up no command that does not need it.
#include "replay/service/command_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <thread>

#include "common/port/memory_transport.h"
#include "tests/common/util/eventually.h"
#include "tests/replay/test_chunks.h"

namespace dadrl {
namespace {

using testing::HasSubstr;

class CommandServerTest : public testing::Test {
 protected:
  CommandServerTest() {
    replay_.min_size = 100;
    replay_.state_interval_s = 3600.0;
    table_ = ReplayTable::Open(
                 {.directory = folder_.path() / "replay" / "shard-0", .spec = kTestSpec, .replay = replay_},
                 clock_)
                 .value();
    maintenance_ = std::make_unique<Maintenance>(replay_, 0, folder_.path(), *table_, clock_);
    server_ = CommandServer::Create(transport_, 0, *table_, *maintenance_, [this] { ++limits_; }).value();
    answers_ = Reader<dadrl_idl_ReplayAnswer>::Create(transport_, kReplayAnswerTopic).value();
    commands_ = Writer<dadrl_idl_ReplayCommand>::Create(transport_, kReplayCommandTopic).value();
  }
  ~CommandServerTest() override {
    stop_ = true;
    if (running_.joinable()) running_.join();
  }
  void RunMaintenance() {
    running_ = std::thread([this] { maintenance_->Run(stop_); });
  }
  static dadrl_idl_ReplayCommand Snapshot(const std::string& name) {
    dadrl_idl_ReplayCommand command{};
    command.kind = static_cast<uint32_t>(ReplayCommandKind::kSnapshot);
    name.copy(command.snapshot, sizeof(command.snapshot) - 1);
    return command;
  }
  static dadrl_idl_ReplayCommand Limit(int64_t min_size) {
    dadrl_idl_ReplayCommand command{};
    command.kind = static_cast<uint32_t>(ReplayCommandKind::kLimit);
    command.min_size = min_size;
    command.samples_per_insert = command.min_samples_per_insert = command.band_frames = -1.0;
    return command;
  }
  // As the tool does it: again and again, under one number.
  void Send(dadrl_idl_ReplayCommand command, uint64_t number) {
    command.command = number;
    EXPECT_TRUE(commands_->Write(command));
  }
  // The text of an answer, once there is one.
  std::string AnswerTo(uint64_t number) {
    EXPECT_TRUE(Eventually([&] {
      Serve();
      return answered_.contains(number);
    }));
    return answered_[number];
  }
  void Serve() {
    server_->Serve();
    answers_->Take(64,
                   [this](const dadrl_idl_ReplayAnswer& answer) { answered_[answer.command] = answer.text; });
  }

  TemporaryFolder folder_;
  SystemClock clock_;
  ReplayConfig replay_;
  std::unique_ptr<ReplayTable> table_;
  std::unique_ptr<Maintenance> maintenance_;
  const MemoryTransport transport_;
  std::unique_ptr<CommandServer> server_;
  std::unique_ptr<Reader<dadrl_idl_ReplayAnswer>> answers_;
  std::unique_ptr<Writer<dadrl_idl_ReplayCommand>> commands_;
  std::map<uint64_t, std::string> answered_;
  int limits_ = 0;
  std::atomic<bool> stop_{false};
  std::thread running_;
};

TEST_F(CommandServerTest, ASnapshotThatTakesForEverHoldsUpNoOtherCommand) {
  Send(Snapshot("slow"), 1);
  Send(Limit(50), 2);
  Send(Limit(0), 3);
  EXPECT_THAT(AnswerTo(3), HasSubstr("from 50 frames on")) << "in force at once";
  EXPECT_EQ(limits_, 1);
  for (int i = 0; i < 100; ++i) Send(Snapshot("slow"), 1);
  Send(Limit(0), 4);
  AnswerTo(4);
  EXPECT_FALSE(answered_.contains(1));
  EXPECT_FALSE(answered_.contains(2)) << "not on disk yet";
  RunMaintenance();
  EXPECT_THAT(AnswerTo(1), HasSubstr("snapshot"));
  EXPECT_THAT(AnswerTo(2), HasSubstr("from 50 frames on"));
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "snapshots" / "shard-0" / "slow"));
}

TEST_F(CommandServerTest, WhatIsRepeatedIsAnsweredAgainAndNotDoneAgain) {
  RunMaintenance();
  Send(Snapshot("once"), 1);
  EXPECT_THAT(AnswerTo(1), HasSubstr("snapshot"));
  answered_.clear();
  Send(Snapshot("once"), 1);
  EXPECT_THAT(AnswerTo(1), HasSubstr("snapshot")) << "and not that it exists";
}

TEST_F(CommandServerTest, MoreThanTheKeeperCanRememberIsRefused) {
  const auto refused = [](const auto& answer) {
    return answer.second.find("wait for its disk already") != std::string::npos;
  };
  EXPECT_TRUE(Eventually([&] {
    for (uint64_t number = 1; number <= Maintenance::kMaxJobs + 1; ++number) {
      Send(Snapshot(fmt::format("s{}", number)), number);
      Serve();
    }
    return std::any_of(answered_.begin(), answered_.end(), refused);
  }));
  EXPECT_EQ(answered_.size(), 1u);
}

}  // namespace
}  // namespace dadrl
