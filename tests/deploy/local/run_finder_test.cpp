#include "deploy/local/run_finder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/config/config_yaml.h"
#include "common/dds/node.h"
#include "common/port/port.h"
#include "proto/topics.h"

namespace dadrl {
namespace {

using testing::HasSubstr;

bool Never() { return false; }

// What shard 0 of a run announces.
class AnnouncedRun {
 public:
  explicit AnnouncedRun(std::string yaml = "", const std::string& key = "") {
    config_.cluster.port = dds::FindFreePort().value();
    config_.algorithm.gamma = 0.77;
    if (yaml.empty()) yaml = ToYaml(config_, false);
    node_ = dds::Node::Create(config_.cluster, 1, dds::Role::kReplay, 0, key).value();
    writer_ = Writer<dadrl_idl_RunConfig>::Create(*node_, kRunConfigTopic).value();
    dadrl_idl_RunConfig message{};
    message.port = config_.cluster.port;
    message.yaml._buffer = reinterpret_cast<uint8_t*>(yaml.data());
    message.yaml._length = message.yaml._maximum = static_cast<uint32_t>(yaml.size());
    EXPECT_TRUE(writer_->Write(message));
  }
  int port() const { return config_.cluster.port; }

 private:
  Config config_;
  std::unique_ptr<dds::Node> node_;
  std::unique_ptr<Writer<dadrl_idl_RunConfig>> writer_;
};

TEST(RunFinder, BringsTheRunsConfiguration) {
  const AnnouncedRun run;
  const auto found = FindRun({.host = "localhost", .port = run.port()}, std::chrono::seconds(30), Never);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->algorithm.gamma, 0.77);
  EXPECT_EQ(found->cluster.port, run.port());
  EXPECT_EQ(found->cluster.host, "127.0.0.1");
}

TEST(RunFinder, WithoutAPortItFindsEveryRunAndAsksWhichOne) {
  const AnnouncedRun first;
  const AnnouncedRun second;
  const auto found = FindRun({.host = "127.0.0.1"}, std::chrono::seconds(30), Never);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kInvalidArgument);
  for (const AnnouncedRun* run : {&first, &second}) {
    EXPECT_THAT(found.error().message, HasSubstr(fmt::format("127.0.0.1:{} (left_turn)", run->port())));
  }
}

TEST(RunFinder, SaysWhatToCheckWhenNobodyAnswers) {
  const int port = dds::FindFreePort().value();
  const auto found = FindRun({.host = "127.0.0.1", .port = port}, std::chrono::milliseconds(100), Never);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(found.error().message, HasSubstr(fmt::format("127.0.0.1:{}", port)));
  EXPECT_THAT(found.error().message, HasSubstr("--key RUN/key"));
}

TEST(RunFinder, IsAnsweredByARunOfThisMachineOnlyWithItsKey) {
  const std::string key(32, 'a');
  const AnnouncedRun run("", key);
  const auto ask = [&](const std::string& shown, Duration patience) {
    return FindRun({.host = "127.0.0.1", .port = run.port(), .key = shown}, patience, Never);
  };
  EXPECT_TRUE(ask(key, std::chrono::seconds(30)));
  const auto without = ask("", std::chrono::seconds(3));
  ASSERT_FALSE(without);
  EXPECT_THAT(without.error().message, HasSubstr("none was given"));
  const auto wrong = ask(std::string(32, 'b'), std::chrono::seconds(3));
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().message, HasSubstr("may be another run's"));
}

TEST(RunFinder, RefusesAConfigurationOfAnotherVersion) {
  const AnnouncedRun run("algorithm: {no_such_key: 1}");
  const auto found = FindRun({.host = "127.0.0.1", .port = run.port()}, std::chrono::seconds(2), Never);
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().message, HasSubstr("no_such_key"));
}

}  // namespace
}  // namespace dadrl
