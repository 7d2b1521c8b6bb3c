// A run on 127.0.0.1 beside others on the same host.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <sys/socket.h>

#include <atomic>
#include <fstream>
#include <set>
#include <sstream>
#include <thread>

#include "common/config/config_yaml.h"
#include "common/io/file_descriptor.h"
#include "tests/integration/cluster_under_test.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

constexpr const char* kGroup = "239.255.76.67";

class Strangers : public testing::Test {
 protected:
  void SetUp() override {
    std::vector<std::string> arguments = {"left_turn"};
    for (const std::string& argument : SmallTraining()) arguments.push_back(argument);
    cluster_.emplace(folder_.path() / "run", arguments);
    training_ = cluster_->MonitorUntil([](const json& monitor) { return IsTraining(monitor); });
    ASSERT_TRUE(training_) << cluster_->Said();
    Config config;
    ASSERT_TRUE(LoadYaml(cluster_->run() / "config.yaml", config));
    port_ = config.cluster.port;
  }
  void TearDown() override {
    if (!cluster_) return;
    cluster_->launcher().Signal(SIGINT);
    EXPECT_EQ(cluster_->WaitForEnd(60), 0) << cluster_->Said();
  }

  std::set<pid_t> Processes() const {
    std::set<pid_t> pids = {cluster_->launcher().pid()};
    for (const json& row : (*training_)["processes"]) pids.insert(row["pid"].get<pid_t>());
    return pids;
  }

  TemporaryFolder folder_;
  mutable std::optional<ClusterUnderTest> cluster_;
  std::optional<json> training_;
  int port_ = 0;
};

// The inodes of a process's sockets.
std::set<std::string> SocketsOf(pid_t pid) {
  std::set<std::string> inodes;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(fmt::format("/proc/{}/fd", pid), error)) {
    const std::string target = fs::read_symlink(entry.path(), error).string();
    if (target.starts_with("socket:[")) inodes.insert(target.substr(8, target.size() - 9));
  }
  return inodes;
}

struct BoundSocket {
  uint32_t address = 0;  // host order
  std::string line;
};

// What `ss -ultpn` lists of a process.
std::vector<BoundSocket> SocketsBoundBy(pid_t pid) {
  const std::set<std::string> inodes = SocketsOf(pid);
  std::vector<BoundSocket> sockets;
  for (const char* table : {"/proc/net/udp", "/proc/net/udp6", "/proc/net/tcp", "/proc/net/tcp6"}) {
    std::ifstream stream(table);
    for (std::string line; std::getline(stream, line);) {
      std::istringstream words(line);
      std::vector<std::string> columns{std::istream_iterator<std::string>(words), {}};
      if (columns.size() < 10 || !inodes.contains(columns[9])) continue;
      const bool v4 = columns[1].size() == 13;
      const auto address = v4 ? static_cast<uint32_t>(std::stoul(columns[1].substr(0, 8), nullptr, 16)) : 0;
      sockets.push_back({ntohl(address), fmt::format("{} {}", table, line)});
    }
  }
  return sockets;
}

void Send(const char* address, int port, const std::string& datagram) {
  const FileDescriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const in_addr loopback{htonl(INADDR_LOOPBACK)};
  setsockopt(socket.get(), IPPROTO_IP, IP_MULTICAST_IF, &loopback, sizeof(loopback));
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = inet_addr(address);
  to.sin_port = htons(static_cast<uint16_t>(port));
  sendto(socket.get(), datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&to),
         sizeof(to));
}

// The pair of fragments once killed the monitor, then the launcher, and the cluster with it.
TEST_F(Strangers, ReachNoSocketAndWhatTheyForgeIsRefusedAndCounted) {
  size_t seen = 0;
  for (const pid_t pid : Processes()) {
    for (const BoundSocket& socket : SocketsBoundBy(pid)) {
      const bool loopback = socket.address >> 24 == IN_LOOPBACKNET;
      EXPECT_TRUE(loopback || socket.address == ntohl(inet_addr(kGroup))) << socket.line;
      ++seen;
    }
  }
  EXPECT_GT(seen, 10u) << "replay, learner, actor and launcher have several each";

  const std::string first = std::string("LC03\0\0\0\7\0\0\3\xe8\0\0\0\0\0\0\0\3", 20) + "DADRL_STATUS" +
                            '\0' + std::string(100, 'A');
  const std::string second =
      std::string("LC03\0\0\0\7\0\0\3\xe8\xff\xff\xff\0\0\1\0\3", 20) + std::string(512, 'B');
  const std::string garbage = std::string("LC02\0\0\0\1DADRL_STATUS\0", 21) + std::string(820, '\xff');
  std::atomic<bool> stop{false};
  std::thread forger([&] {
    while (!stop) {
      for (const std::string& datagram : {first, second, garbage}) {
        for (const char* address : {"127.0.0.1", kGroup}) Send(address, port_ + 5, datagram);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  });
  const auto monitor = cluster_->MonitorUntil([](const json& m) {
    return IsTraining(m) && m["rejected"].contains("telemetry: fragment") &&
           m["rejected"].contains("telemetry: impossible contents");
  });
  stop = true;
  forger.join();
  ASSERT_TRUE(monitor) << cluster_->Said();
  for (const char* name : {"replay-0", "learner", "actor-0"}) {
    EXPECT_EQ(PidOf(*monitor, name), PidOf(*training_, name)) << name;
  }
}

TEST_F(Strangers, WithoutTheKeyDoNotTakePart) {
  const std::string place = fmt::format("127.0.0.1:{}", port_);
  const auto join = [&](const std::string& key) {
    return Dadrl({"actor", "--join", place, "--key", key, "--run-dir", folder_.path() / "join"});
  };
  const fs::path wrong = folder_.path() / "wrong";
  std::ofstream(wrong) << std::string(32, 'a') << '\n';
  const CommandOutput refused = join(wrong);
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, testing::HasSubstr("may be another run's: name it with --key RUN/key"));

  auto actor = ChildProcess::Spawn(
      {.command = {DadrlProgram(), "actor", "--join", place, "--key", cluster_->run() / "key",
                   "--first-index", "77", "--run-dir", folder_.path() / "friend"},
       .log = folder_.path() / "friend.log"});
  ASSERT_TRUE(actor);
  EXPECT_TRUE(cluster_->MonitorUntil([](const json& m) { return m["actors_alive"] == 2; }))
      << FileText(folder_.path() / "friend.log") << cluster_->Said();
  actor->Signal(SIGINT);
  EXPECT_TRUE(Eventually([&] { return actor->TryWait().has_value(); }, std::chrono::seconds(30)));
}

}  // namespace
}  // namespace dadrl
