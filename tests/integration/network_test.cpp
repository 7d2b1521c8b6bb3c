// Two machines: network namespaces joined by a cable that can be pulled. Needs root and iproute2.
#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <sstream>

#include "tests/integration/cluster_under_test.h"
#include "tests/integration/stored_experience.h"

namespace dadrl {
namespace {

// One of the two ends; gone with the object, whatever is left in it.
class Machine {
 public:
  Machine(const std::string& name, std::string address)
      : name_(fmt::format("dadrl-{}-{}", getpid(), name)), address_(std::move(address)) {
    Ip({"netns", "add", name_});
  }
  ~Machine() { RunCommand({"ip", "netns", "del", name_}); }
  Machine(const Machine&) = delete;
  Machine& operator=(const Machine&) = delete;

  // A veth end cannot bear a longer name than this.
  std::string device() const { return fmt::format("v{}{}", getpid(), name_.back()); }
  // `command` inside, with what it said.
  std::string Ask(std::vector<std::string> command) const {
    const CommandOutput output = RunCommand(Inside(std::move(command)));
    EXPECT_EQ(output.exit_code, 0) << output.err;
    return output.out;
  }
  const std::string& name() const { return name_; }
  const std::string& address() const { return address_; }
  std::vector<std::string> Inside(std::vector<std::string> command) const {
    command.insert(command.begin(), {"ip", "netns", "exec", name_});
    return command;
  }
  void Connect() const {
    Ip({"-n", name_, "addr", "add", address_ + "/24", "dev", device()});
    Ip({"-n", name_, "link", "set", "lo", "up"});
    SetLink(true);
  }
  void SetLink(bool up) const { Ip({"-n", name_, "link", "set", device(), up ? "up" : "down"}); }

  static void Ip(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "ip");
    const CommandOutput output = RunCommand(arguments);
    ASSERT_EQ(output.exit_code, 0) << fmt::format("{}", fmt::join(arguments, " ")) << ": " << output.err;
  }

 private:
  std::string name_;
  std::string address_;
};

// A third of the default: a cut of ten leases takes ten seconds here, and half a minute there.
constexpr double kLease_s = 1.0;
constexpr double kCut_s = 10.0 * kLease_s;
// Less than the actor drives during the cut.
constexpr int kMaxBytes = 1 << 16;

// How often an actor has begun to wait for the replay.
uint64_t WaitsForReplay(const json& monitor) {
  uint64_t count = 0;
  for (const json& wait : monitor["waits"]) {
    const bool actors = wait["who"].get<std::string>().starts_with("actor");
    if (actors && wait["for"] == "replay") count += wait["count"].get<uint64_t>();
  }
  return count;
}

class TwoMachines : public testing::Test {
 protected:
  void SetUp() override {
    if (geteuid() != 0) GTEST_SKIP() << "only root may make network namespaces";
    Machine::Ip({"link", "add", centre_.device(), "netns", centre_.name(), "type", "veth", "peer", "name",
                 edge_.device(), "netns", edge_.name()});
    centre_.Connect();
    edge_.Connect();
    Prepare();
    std::vector<std::string> train = {DadrlProgram(), "train", "left_turn"};
    for (const std::string& argument : SmallTraining()) train.push_back(argument);
    *(std::find(train.begin(), train.end(), "--actors") + 1) = "0";
    train.insert(train.end(), {"--set", "cluster.host=" + centre_.address(),                          //
                               "--set", fmt::format("cluster.lease_s={}", kLease_s),                  //
                               "--set", fmt::format("actor.max_unacknowledged_bytes={}", kMaxBytes),  //
                               "--run-dir", run_.string()});
    training_ = Start(centre_, std::move(train));
    ASSERT_TRUE(Eventually([&] { return std::filesystem::exists(run_ / "config.yaml"); })) << Said();
    actors_ = Start(edge_, {DadrlProgram(), "actor", "--join", centre_.address(), "--run-dir",
                            (folder_.path() / "edge").string()});
    ASSERT_TRUE(MonitorUntil([](const json& monitor) { return IsTraining(monitor); })) << Said();
  }
  // The cable is there, and nothing uses it yet.
  virtual void Prepare() {}
  void TearDown() override {
    if (actors_) Stop(*actors_);
    if (training_) Stop(*training_);
  }

  std::optional<ChildProcess> Start(const Machine& machine, std::vector<std::string> command) {
    auto child = ChildProcess::Spawn({.command = machine.Inside(std::move(command)), .log = log_});
    EXPECT_TRUE(child);
    if (!child) return std::nullopt;
    return std::move(*child);
  }
  void Stop(ChildProcess& child) {
    child.Signal(SIGINT);
    EXPECT_TRUE(Eventually([&] { return child.TryWait().has_value(); }, std::chrono::seconds(60))) << Said();
  }
  std::optional<json> MonitorUntil(const std::function<bool(const json&)>& condition) {
    std::optional<json> answer;
    const bool held = Eventually(
        [&] {
          const CommandOutput output =
              RunCommand(centre_.Inside({DadrlProgram(), "monitor", "--json", "--run-dir", run_.string()}));
          if (output.exit_code != 0) return false;
          answer = json::parse(output.out, nullptr, false);
          return answer->is_object() && condition(*answer);
        },
        std::chrono::seconds(90));
    return held ? answer : std::nullopt;
  }
  std::string Said() const { return FileText(log_); }

  TemporaryFolder folder_;
  const std::filesystem::path run_ = folder_.path() / "run";
  const std::filesystem::path log_ = folder_.path() / "log";
  const Machine centre_{"a", "10.213.77.1"};
  const Machine edge_{"b", "10.213.77.2"};
  std::optional<ChildProcess> training_;
  std::optional<ChildProcess> actors_;
};

// The edge reaches the centre by its address alone, and the centre sees the edge's actor: SetUp waits for it.
TEST_F(TwoMachines, APulledCableCostsAndRepeatsNothingAndTrainingGoesOnByItself) {
  const auto before = MonitorUntil([](const json& monitor) { return IsTraining(monitor); });
  ASSERT_TRUE(before) << Said();
  edge_.SetLink(false);
  // Long after the lease: DDS itself has given up, and the centre knows nothing of its actor any more.
  const auto uptime = [](const json& monitor) {
    return ProcessIn(monitor, "learner")["uptime_s"].get<double>();
  };
  ASSERT_TRUE(MonitorUntil([&](const json& monitor) {
    return monitor["actors_alive"] == 0 && uptime(monitor) > uptime(*before) + kCut_s;
  })) << Said();
  edge_.SetLink(true);
  const auto after = MonitorUntil([&](const json& monitor) {
    return IsTraining(monitor) && monitor["inserted_frames_per_s"] > 0.0 &&
           monitor["updates"] > (*before)["updates"].get<double>() + 20;
  });
  ASSERT_TRUE(after) << Said();
  for (const char* name : {"replay-0", "learner"}) EXPECT_EQ(PidOf(*after, name), PidOf(*before, name));
  EXPECT_GT(WaitsForReplay(*after), WaitsForReplay(*before)) << "what an actor may keep has no bound";

  Stop(*actors_);
  actors_.reset();
  Stop(*training_);
  training_.reset();
  ExpectEveryChunkOnce(run_);
  // The machine that joined has its episodes itself; the run counts its own machine's, and there are none.
  const std::string driven = FileText(folder_.path() / "edge" / "episodes.csv");
  EXPECT_GT(std::count(driven.begin(), driven.end(), '\n'), 1);
  EXPECT_EQ(json::parse(FileText(run_ / "results.json"))["training_episodes"], 0);
}

// 0 while the cluster hears of none.
pid_t LiveActor(const json& monitor) {
  for (const json& row : monitor["processes"]) {
    if (row["name"].get<std::string>().starts_with("actor") && row["stale"] == false) {
      return row["pid"].get<pid_t>();
    }
  }
  return 0;
}

// Its lease ran out, or it was carried to another place.
TEST_F(TwoMachines, AnActorWhoseMachineGetsAnotherAddressIsBackWithinSeconds) {
  const auto before = MonitorUntil([](const json& monitor) { return LiveActor(monitor) != 0; });
  ASSERT_TRUE(before) << Said();
  Machine::Ip({"-n", edge_.name(), "addr", "del", edge_.address() + "/24", "dev", edge_.device()});
  Machine::Ip({"-n", edge_.name(), "addr", "add", "10.213.77.7/24", "dev", edge_.device()});
  EXPECT_TRUE(MonitorUntil([&](const json& monitor) {
    const pid_t pid = LiveActor(monitor);
    return pid != 0 && pid != LiveActor(*before) && monitor["inserted_frames_per_s"] > 0.0;
  })) << Said();
}

// A tunnel between the two, and a router that drops IP fragments.
class NarrowPath : public TwoMachines {
 protected:
  void Prepare() override {
    for (const Machine* machine : {&centre_, &edge_}) {
      Machine::Ip({"-n", machine->name(), "link", "set", machine->device(), "mtu", "1400"});
      machine->Ask({"sysctl", "-qw", "net.ipv4.ipfrag_low_thresh=0", "net.ipv4.ipfrag_high_thresh=0"});
    }
  }
  // IP packets that a machine has cut into pieces.
  static uint64_t FragmentsOf(const Machine& machine) {
    std::istringstream table(machine.Ask({"cat", "/proc/net/snmp"}));
    std::string names;
    std::string values;
    for (std::string line; names.empty() && std::getline(table, line);) {
      if (line.starts_with("Ip:")) names = line;
    }
    std::getline(table, values);
    std::istringstream name(names);
    std::istringstream value(values);
    for (std::string n, v; name >> n && value >> v;) {
      if (n == "FragCreates") return std::stoull(v);
    }
    ADD_FAILURE() << "no FragCreates in " << names;
    return 0;
  }
};

TEST_F(NarrowPath, IsPassedByWholePackets) {
  EXPECT_TRUE(MonitorUntil([](const json& monitor) {
    return IsTraining(monitor) && monitor["inserted_frames_per_s"] > 0.0 && monitor["updates"] > 50;
  })) << Said();
  for (const Machine* machine : {&centre_, &edge_}) EXPECT_EQ(FragmentsOf(*machine), 0u);
}

// LCM opens there, and hears nothing: as in a container of its own.
TEST_F(TwoMachines, AMonitorThatHearsNothingSaysWhatItWaitsForAndWhatWouldHelp) {
  std::vector<std::string> command = {DadrlProgram(), "monitor", "--run-dir", run_.string()};
  auto live = Start(edge_, command);
  ASSERT_TRUE(live);
  command.emplace_back("--json");
  const CommandOutput once = RunCommand(edge_.Inside(command));
  EXPECT_EQ(once.exit_code, 1);
  EXPECT_EQ(once.out, "");
  EXPECT_THAT(once.err, testing::HasSubstr("no telemetry heard in 5 s"));
  EXPECT_THAT(once.err, testing::HasSubstr("another host or container than its replay's"));
  EXPECT_TRUE(Eventually([&] { return Said().find("still listening") != std::string::npos; })) << Said();
  EXPECT_FALSE(live->TryWait());
  Stop(*live);
}

}  // namespace
}  // namespace dadrl
