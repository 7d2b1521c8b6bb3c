#include "proto/telemetry.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <set>

#include "common/dds/udp_socket.h"
#include "proto/telemetry_packet.h"

namespace dadrl {
namespace {

ProcessStatus SomeStatus() {
  ProcessStatus status;
  status.role = dds::Role::kReplay;
  status.index = 3;
  status.pid = 4711;
  status.incarnation = 0xfedcba9876543210;
  status.sent_ns = 1234567890123;
  status.uptime_s = 12.5;
  for (size_t i = 0; i < status.metrics.size(); ++i) status.metrics[i] = 0.5 + static_cast<double>(i);
  for (size_t i = 0; i < status.activities.size(); ++i) {
    status.activities[static_cast<Activity>(i)] = {1000 + i, 100.0 + static_cast<double>(i)};
  }
  status.faults = {{FaultKind::kExperience, "cannot write /a b/segment: No space left on device", 3.5},
                   {FaultKind::kState, "the same", 0.0}};
  status.scalars = {{"value_loss", 0.5}, {std::string(kMaxScalarName, 'x'), -1e9}, {"q2", 0.0}};
  return status;
}

EpisodeReport SomeReport() {
  EpisodeReport report;
  report.scenario = "left_turn";
  report.outcome = 2;
  report.episode_return = -1.25;
  return report;
}

void ExpectEqual(const ProcessStatus& a, const ProcessStatus& b) {
  EXPECT_EQ(a.role, b.role);
  EXPECT_EQ(a.index, b.index);
  EXPECT_EQ(a.pid, b.pid);
  EXPECT_EQ(a.incarnation, b.incarnation);
  EXPECT_EQ(a.sent_ns, b.sent_ns);
  EXPECT_EQ(a.uptime_s, b.uptime_s);
  EXPECT_EQ(a.metrics, b.metrics);
  EXPECT_EQ(a.activities, b.activities);
  EXPECT_EQ(a.faults, b.faults);
  EXPECT_EQ(a.scalars, b.scalars);
}

TEST(MetricName, IsDifferentForEveryMetric) {
  std::set<std::string_view> names;
  for (int i = 0; i < static_cast<int>(Metric::kCount); ++i) names.insert(MetricName(static_cast<Metric>(i)));
  EXPECT_EQ(names.size(), static_cast<size_t>(Metric::kCount));
  EXPECT_EQ(MetricName(Metric::kEnvSteps), "env_steps");
  EXPECT_EQ(MetricName(Metric::kCheckpointAgeS), "checkpoint_age_s");
}

TEST(TelemetryPacket, KeepsEveryField) {
  ExpectEqual(DecodeStatusPacket(EncodePacket(SomeStatus())).value(), SomeStatus());
  const EpisodeReport report = DecodeEpisodePacket(EncodePacket(SomeReport())).value();
  EXPECT_EQ(report.outcome, 2);
  EXPECT_EQ(report.episode_return, -1.25);
  EXPECT_EQ(report.scenario, "left_turn");
}

TEST(TelemetryPacket, FitsTheRelaysMessage) {
  EXPECT_LE(EncodePacket(SomeStatus()).size(), 2048u) << "the bound of Telemetry in cluster.idl";
}

TEST(TelemetryPacket, CutsFaultsThatDoNotFitAndRefusesThoseThatCannotBe) {
  ProcessStatus status = SomeStatus();
  status.faults.assign(9, {FaultKind::kResults, std::string(400, 'x'), 1.0});
  const auto cut = DecodeStatusPacket(EncodePacket(status))->faults;
  ASSERT_EQ(cut.size(), ProcessStatus::kMaxFaults);
  EXPECT_EQ(cut.back().text, std::string(ProcessStatus::kMaxFaultText, 'x'));
  status.faults = {{FaultKind::kResults, "\x1b[2J", 1.0}};
  EXPECT_EQ(DecodeStatusPacket(EncodePacket(status))->faults.front().text, "?[2J");
  status.faults.front() = {FaultKind::kCount, "x", 1.0};
  EXPECT_FALSE(DecodeStatusPacket(EncodePacket(status)));
  status.faults.front() = {FaultKind::kState, "x", -1.0};
  EXPECT_FALSE(DecodeStatusPacket(EncodePacket(status)));
  status.faults.front().since_s = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(DecodeStatusPacket(EncodePacket(status)));
  status.faults.front() = {FaultKind::kState, "x", 1.0};
  std::vector<std::byte> forged = EncodePacket(status);
  forged[forged.size() - 4 * (ProcessStatus::kMaxFaultText + 1)] = std::byte{'\n'};
  EXPECT_FALSE(DecodeStatusPacket(forged));
}

TEST(TelemetryPacket, CutsALongScenarioAndRefusesOneThatIsNotText) {
  EpisodeReport report = SomeReport();
  report.scenario.clear();
  EXPECT_EQ(DecodeEpisodePacket(EncodePacket(report))->scenario, "");
  report.scenario = std::string(40, 'x');
  EXPECT_EQ(DecodeEpisodePacket(EncodePacket(report))->scenario, std::string(31, 'x'));
  report.scenario = std::string(30, 'x') + "ü";
  EXPECT_EQ(DecodeEpisodePacket(EncodePacket(report))->scenario, std::string(30, 'x'));
  for (const char* good : {"left turn", "left,turn", "left\"turn", "Mündung"}) {
    report.scenario = good;
    EXPECT_EQ(DecodeEpisodePacket(EncodePacket(report))->scenario, good);
  }
  for (const char* bad : {"left\nturn", "\x1b[2J", "\xc2\x9b", "\xff"}) {
    report.scenario = bad;
    EXPECT_FALSE(DecodeEpisodePacket(EncodePacket(report))) << bad;
  }
  report.scenario = "x";
  std::vector<std::byte> unterminated = EncodePacket(report);
  std::fill(unterminated.end() - 32, unterminated.end(), std::byte{'x'});
  EXPECT_FALSE(DecodeEpisodePacket(unterminated));
}

TEST(TelemetryPacket, RefusesWhatIsNotExactlyOnePacket) {
  const std::vector<std::byte> whole = EncodePacket(SomeStatus());
  for (size_t length = 0; length < whole.size(); ++length) {
    EXPECT_FALSE(DecodeStatusPacket(std::span(whole).first(length)));
  }
  std::vector<std::byte> longer = whole;
  longer.push_back(std::byte{0});
  EXPECT_FALSE(DecodeStatusPacket(longer));
  std::vector<std::byte> foreign = whole;
  foreign[3] ^= std::byte{1};  // fingerprint
  EXPECT_FALSE(DecodeStatusPacket(foreign));
  EXPECT_FALSE(DecodeStatusPacket(EncodePacket(SomeReport())));
}

TEST(TelemetryPacket, RefusesValuesThatCannotBe) {
  ProcessStatus status = SomeStatus();
  status.role = static_cast<dds::Role>(4);
  EXPECT_FALSE(DecodeStatusPacket(EncodePacket(status)));
  status = SomeStatus();
  status.index = -1;
  EXPECT_FALSE(DecodeStatusPacket(EncodePacket(status)));
  const auto refuses = [](const std::function<void(ProcessStatus&)>& change) {
    ProcessStatus changed = SomeStatus();
    change(changed);
    return !DecodeStatusPacket(EncodePacket(changed));
  };
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(refuses([](ProcessStatus& s) { s[Metric::kUpdates] = kNaN; }));
  EXPECT_FALSE(refuses([](ProcessStatus& s) { s[Metric::kPolicyAgeS] = -0.1; }));
  EXPECT_TRUE(refuses([](ProcessStatus& s) { s[Metric::kEnvSteps] = -1.0; }));
  EXPECT_TRUE(refuses([](ProcessStatus& s) { s[Metric::kInsertedBytes] = 1e300; }));
  EXPECT_TRUE(refuses([](ProcessStatus& s) { s.uptime_s = -1.0; }));
  EXPECT_TRUE(refuses([](ProcessStatus& s) { s.pid = -1; }));
  EXPECT_TRUE(refuses([](ProcessStatus& s) { s.activities[Activity::kWork].seconds = kNaN; }));
  EXPECT_TRUE(refuses([](ProcessStatus& s) { s.activities[Activity::kWork].count = ~uint64_t{0}; }));
  EXPECT_TRUE(refuses([](ProcessStatus& s) { s.index = dds::kMaxShards; }));
  EXPECT_TRUE(refuses([](ProcessStatus& s) { s.role = dds::Role::kLearner; })) << "there is one";
  EXPECT_TRUE(refuses([](ProcessStatus& s) {
    s.role = dds::Role::kActor;
    s.index = kMaxActorNumber + 1;
  }));
  EpisodeReport report = SomeReport();
  report.outcome = 4;
  EXPECT_FALSE(DecodeEpisodePacket(EncodePacket(report)));
  for (const double value : {kNaN, std::numeric_limits<double>::infinity(), 1e10, -1e10}) {
    report = SomeReport();
    report.episode_return = value;
    EXPECT_FALSE(DecodeEpisodePacket(EncodePacket(report))) << value;
  }
}

TEST(TelemetryPacket, LeavesOutScalarsThatNoReaderWouldTake) {
  ProcessStatus status;
  for (const double value : {std::nan(""), HUGE_VAL, -1e300}) status.scalars.push_back({"loss", value});
  for (const char* name : {"", "Loss", "a b", "\x1b[2J", "übergang", "a_name_of_twenty_four_b_"}) {
    status.scalars.push_back({name, 1.0});
  }
  EXPECT_TRUE(DecodeStatusPacket(EncodePacket(status))->scalars.empty());
  for (int i = 0; i < 20; ++i) status.scalars.push_back({fmt::format("s{}", i), 1.0});
  const auto scalars = DecodeStatusPacket(EncodePacket(status))->scalars;
  ASSERT_EQ(scalars.size(), size_t{kMaxScalars});
  EXPECT_EQ(scalars.back().name, "s15");
}

TEST(TelemetryPacket, RefusesForgedScalars) {
  ProcessStatus status;
  status.scalars = {{"one", 1.0}, {"two", 2.0}};
  const std::vector<std::byte> whole = EncodePacket(status);
  const size_t faults = 4 + ProcessStatus::kMaxFaults * (4 + 8 + ProcessStatus::kMaxFaultText + 1);
  const size_t values = whole.size() - faults - 8 * size_t{kMaxScalars};
  const size_t names = values - (kMaxScalarName + 1) * size_t{kMaxScalars};
  const auto refuses = [&](size_t at, std::string_view bytes) {
    std::vector<std::byte> forged = whole;
    std::ranges::copy(std::as_bytes(std::span(bytes)), forged.begin() + static_cast<ptrdiff_t>(at));
    return !DecodeStatusPacket(forged);
  };
  EXPECT_FALSE(refuses(names, "ten"));
  EXPECT_TRUE(refuses(names, "\x1b[2"));
  EXPECT_TRUE(refuses(names, "two")) << "twice";
  EXPECT_TRUE(refuses(names, std::string_view("\0ne", 3)));
  EXPECT_TRUE(refuses(names, std::string(kMaxScalarName + 1, 'x'))) << "without an end";
  EXPECT_TRUE(refuses(values, "\x7f\xf0")) << "infinite";
  const size_t count = 8 + 5 * 4;  // fingerprint, role, index, pid and two counts
  EXPECT_FALSE(refuses(count, std::string_view("\0\0\0\1", 4)));
  EXPECT_TRUE(refuses(count, std::string_view("\0\0\0\3", 4))) << "a third without a name";
  EXPECT_TRUE(refuses(count, std::string_view("\0\0\0\x7f", 4)));
  EXPECT_TRUE(refuses(count, "\xff\xff\xff\xff"));
}

TEST(TelemetryPacket, RefusesASenderThatCountsOtherMetrics) {
  std::vector<std::byte> packet = EncodePacket(SomeStatus());
  packet[8 + 3 * 4 + 3] ^= std::byte{1};  // metric_count, big endian, after fingerprint, role, index and pid
  const auto status = DecodeStatusPacket(packet);
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().message, ::testing::HasSubstr("another version"));
}

// Real multicast on this host, on a port of its own.
class TelemetryBusTest : public ::testing::Test {
 protected:
  void SetUp() override {
    cluster_.port = dds::FindFreePort().value();
    auto subscriber = TelemetrySubscriber::Create(TelemetryUrl(cluster_));
    if (!subscriber) GTEST_SKIP() << "no multicast here: " << subscriber.error().message;
    subscriber_ = std::move(*subscriber);
  }

  // One datagram as LCM frames short messages: magic, sequence number, channel, payload.
  void SendDatagram(const std::string& channel, std::span<const std::byte> payload) {
    std::string datagram("LC02\0\0\0\1", 8);
    datagram += channel;
    datagram += '\0';
    datagram.append(reinterpret_cast<const char*>(payload.data()), payload.size());
    SendRaw(datagram);
  }
  void SendRaw(const std::string& datagram) {
    const dds::UdpSocket socket;
    const in_addr loopback{htonl(INADDR_LOOPBACK)};
    ::setsockopt(socket.descriptor(), IPPROTO_IP, IP_MULTICAST_IF, &loopback, sizeof(loopback));
    const sockaddr_in group = dds::SocketAddress(::inet_addr("239.255.76.67"), cluster_.port + 5);
    ASSERT_EQ(::sendto(socket.descriptor(), datagram.data(), datagram.size(), 0,
                       reinterpret_cast<const sockaddr*>(&group), sizeof(group)),
              static_cast<ssize_t>(datagram.size()));
  }
  // Polls until `done`, ten seconds at most.
  bool PollUntil(const std::function<bool()>& done) {
    for (int i = 0; i < 1000 && !done(); ++i) {
      subscriber_->Poll(
          std::chrono::milliseconds(10), [&](const ProcessStatus& status) { statuses_.push_back(status); },
          [&](const EpisodeReport& report) { reports_.push_back(report); });
    }
    return done();
  }

  ClusterConfig cluster_;
  std::unique_ptr<TelemetrySubscriber> subscriber_;
  std::vector<ProcessStatus> statuses_;
  std::vector<EpisodeReport> reports_;
};

TEST_F(TelemetryBusTest, CarriesStatusAndEpisodes) {
  TelemetryPublisher publisher(TelemetryUrl(cluster_));
  publisher.Publish(SomeStatus());
  publisher.Publish(SomeReport());
  ASSERT_TRUE(PollUntil([&] { return !statuses_.empty() && !reports_.empty(); }));
  ExpectEqual(statuses_[0], SomeStatus());
  EXPECT_EQ(reports_[0].scenario, SomeReport().scenario);
  EXPECT_TRUE(subscriber_->refusals().empty());
}

TEST_F(TelemetryBusTest, DropsAndCountsForgedPackets) {
  const std::vector<std::byte> whole = EncodePacket(SomeStatus());
  SendDatagram("DADRL_STATUS", {});
  SendDatagram("DADRL_STATUS", std::span(whole).first(8));  // fingerprint only
  SendDatagram("DADRL_STATUS", std::span(whole).first(whole.size() - 1));
  SendDatagram("DADRL_EPISODE", whole);  // right type, wrong channel
  SendDatagram("DADRL_STATUS", std::vector<std::byte>(60000, std::byte{0xff}));
  SendRaw("LC");                            // no whole header
  SendRaw("LC02");                          // no sequence number
  SendRaw("LC02" + std::string(200, 'x'));  // a channel that never ends
  SendRaw(std::string(1000, '\xff'));
  SendRaw(std::string("LC03") + std::string(40, '\xff'));  // fragment of an impossible message
  SendDatagram("DADRL_STATUS", whole);
  ASSERT_TRUE(PollUntil([&] { return !statuses_.empty(); }));
  ExpectEqual(statuses_[0], SomeStatus());
  EXPECT_EQ(subscriber_->refusals(),
            (TelemetryRefusals{{"impossible contents", 5}, {"malformed", 4}, {"fragment", 1}}));
  EXPECT_EQ(statuses_.size(), 1);
  EXPECT_TRUE(reports_.empty());
}

TEST_F(TelemetryBusTest, ClustersOnOneHostDoNotHearEachOther) {
  ClusterConfig other;
  other.port = dds::FindFreePort().value();
  TelemetryPublisher stranger(TelemetryUrl(other));
  TelemetryPublisher publisher(TelemetryUrl(cluster_));
  ProcessStatus strange = SomeStatus();
  strange.index = 99;
  stranger.Publish(strange);
  publisher.Publish(SomeStatus());
  ASSERT_TRUE(PollUntil([&] { return !statuses_.empty(); }));
  EXPECT_EQ(statuses_.size(), 1);
  EXPECT_EQ(statuses_[0].index, SomeStatus().index);
}

TEST(TelemetryPublisher, CarriesOnWhereItCannotSend) {
  TelemetryPublisher off("");
  off.Publish(SomeStatus());
  TelemetryPublisher nowhere("udpm://300.0.0.1:1?ttl=0");
  nowhere.Publish(SomeStatus());
  EXPECT_EQ(TelemetrySubscriber::Create("udpm://300.0.0.1:1?ttl=0").error().code,
            ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace dadrl
