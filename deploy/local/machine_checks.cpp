#include "deploy/local/machine_checks.h"

#include <sys/timex.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <fstream>

#include "common/dds/node.h"
#include "deploy/local/captured_process.h"
#include "deploy/local/cluster_address.h"
#include "deploy/local/executables.h"
#include "deploy/local/folder_check.h"
#include "deploy/local/system_call_checks.h"
#include "proto/telemetry.h"

namespace dadrl {
namespace {

constexpr double kGiB = 1024.0 * 1024.0 * 1024.0;

struct CommandResult {
  bool ran = false;  // and ended with exit code 0
  std::string output;
};

// Runs a short command and returns what it printed; killed after ten seconds.
CommandResult Capture(std::vector<std::string> command) {
  auto process = CapturedProcess::Spawn(std::move(command));
  if (!process) return {.ran = false, .output = process.error().message};
  const auto status = process->child().Wait(std::chrono::seconds(10));
  if (!status) return {.ran = false, .output = "it does not answer within ten seconds"};
  const std::string output = process->Output();
  return {.ran = status->success(), .output = output.empty() ? process->LastMessage() : output};
}

std::string FirstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

// A start with --help loads every shared library that the program needs.
MachineCheck CheckProgram(const std::string& name) {
  MachineCheck check{.name = name, .detail = "starts", .remedy = ""};
  const auto program = FindExecutable(name);
  if (!program) return {name, CheckState::kBroken, "not built", program.error().message};
  const CommandResult help = Capture({program->string(), "--help"});
  if (help.ran) return check;
  return {name, CheckState::kBroken, FirstLine(help.output),
          "install the packages of deploy/packages.txt (deploy/quickstart.sh does)"};
}

MachineCheck CheckSumo() {
  const CommandResult version = Capture({"sumo", "--version"});
  if (version.ran) return {"SUMO", CheckState::kGood, FirstLine(version.output), ""};
  return {"SUMO", CheckState::kBroken, FirstLine(version.output),
          "apt-get install --no-install-recommends sumo"};
}

MachineCheck CheckScenarios() {
  const std::vector<std::string> names = ScenarioNames();
  if (names.empty()) {
    return {"scenarios", CheckState::kBroken, "none in " + ScenarioFolder().string(),
            "build everything: cmake --build --preset release"};
  }
  return {"scenarios", CheckState::kGood, fmt::format("{}", fmt::join(names, ", ")), ""};
}

MachineCheck CheckPorts(int port) {
  if (port > 0) return {"UDP ports", CheckState::kGood, fmt::format("block at {}", port), ""};
  return {"UDP ports", CheckState::kBroken, "no free block", "stop other clusters, or set cluster.port"};
}

// Whether a packet that this host multicasts comes back to it, as LCM needs.
MachineCheck CheckMulticast(const ClusterConfig& cluster) {
  const std::string remedy = "ip link set lo up (without, telemetry goes over DDS)";
  const std::string url = TelemetryUrl(cluster);
  const auto subscriber = TelemetrySubscriber::Create(url);
  if (!subscriber) return {"multicast", CheckState::kWarning, subscriber.error().message, remedy};
  TelemetryPublisher publisher(url);
  bool heard = false;
  ProcessStatus probe;
  probe.role = dds::Role::kMonitor;
  for (int i = 0; i < 20 && !heard; ++i) {
    publisher.Publish(probe);
    (*subscriber)
        ->Poll(
            std::chrono::milliseconds(50), [&](const ProcessStatus&) { heard = true; },
            [](const EpisodeReport&) {});
  }
  if (heard) return {"multicast", CheckState::kGood, "this host hears itself", ""};
  return {"multicast", CheckState::kWarning, "this host does not hear itself", remedy};
}

// Where others would reach a cluster of this machine.
MachineCheck CheckAddress(const ClusterConfig& cluster) {
  const auto address = ClusterAddress(cluster.host);
  if (!address) {
    return {"address", CheckState::kBroken, address.error().message, "--set cluster.host=ADDRESS"};
  }
  if (dds::IsLoopback(*address)) {
    return {"address", CheckState::kGood, *address + ": this machine alone, who has RUN/key", ""};
  }
  std::string packets;
  for (const dds::LocalAddress& local : dds::LocalAddresses()) {
    if (local.address != *address) continue;
    const int mtu = cluster.mtu > 0 ? cluster.mtu : local.mtu;
    packets = fmt::format(" ({}), packets of at most {} bytes", local.interface, mtu);
  }
  return {"address", CheckState::kGood,
          *address + packets + (cluster.require_key ? ", who has RUN/key" : ", whoever reaches it"), ""};
}

MachineCheck CheckClock() {
  constexpr std::time_t kPlausible = 1'700'000'000;  // November 2023
  if (std::time(nullptr) < kPlausible) {
    return {"clock", CheckState::kBroken, "the date lies years back", "set the date"};
  }
  timex state{};
  if (adjtimex(&state) == TIME_ERROR) {
    return {"clock", CheckState::kWarning, "not synchronised (matters only across machines)",
            "run an NTP client, e.g. apt-get install chrony"};
  }
  return {"clock", CheckState::kGood, "synchronised", ""};
}

int64_t NumberIn(const std::filesystem::path& file) {
  std::ifstream stream(file);
  int64_t value = 0;
  stream >> value;
  return value;
}

}  // namespace

MachineCheck CheckReceiveBuffer(int64_t wanted_bytes, int64_t system_limit_bytes) {
  const std::string found = fmt::format("{:.1f} MiB allowed", system_limit_bytes / 0x1p20);
  if (system_limit_bytes >= wanted_bytes) return {"UDP buffers", CheckState::kGood, found, ""};
  return {"UDP buffers", CheckState::kWarning, found + ", big batches may be sent twice",
          fmt::format("sysctl -w net.core.rmem_max={}", wanted_bytes)};
}

MachineCheck CheckDisk(const std::string& folder, double free_bytes, double wanted_bytes) {
  const std::string found = fmt::format("{:.1f} GiB free in {}", free_bytes / kGiB, folder);
  if (free_bytes >= wanted_bytes) return {"disk", CheckState::kGood, found, ""};
  const std::string remedy =
      fmt::format("free {:.1f} GiB, use another --run-dir, or lower replay.max_disk_bytes",
                  (wanted_bytes - free_bytes) / kGiB);
  return {"disk", free_bytes < kGiB ? CheckState::kBroken : CheckState::kWarning, found, remedy};
}

MachineCheck CheckMemory(const UsableMemory& memory, double wanted_bytes) {
  const std::string found =
      fmt::format("{:.1f} GiB available{}", memory.bytes / kGiB, memory.of_cgroup ? " to this cgroup" : "");
  if (memory.bytes >= wanted_bytes) return {"memory", CheckState::kGood, found, ""};
  return {"memory", CheckState::kWarning, found,
          fmt::format("lower replay.max_memory_bytes or actor.count; {:.1f} GiB "
                      "would suffice",
                      wanted_bytes / kGiB)};
}

MachineCheck CheckCores(int cores, int processes) {
  const std::string found = fmt::format("{} for {} busy processes", cores, processes);
  if (cores >= processes) return {"cores", CheckState::kGood, found, ""};
  return {"cores", CheckState::kWarning, found, "expect training to be slower; fewer actors (--actors) help"};
}

std::vector<MachineCheck> CheckMachine(const Config& config) {
  std::vector<MachineCheck> checks;
  for (const char* program : {"dadrl-replay", "dadrl-learner", "dadrl-actor"})
    checks.push_back(CheckProgram(program));
  checks.push_back(CheckSumo());
  checks.push_back(CheckScenarios());
  Config probe = config;
  if (probe.cluster.port == 0) probe.cluster.port = dds::FindFreePort().value_or(0);
  checks.push_back(CheckPorts(probe.cluster.port));
  checks.push_back(CheckAddress(config.cluster));
  checks.push_back(CheckMulticast(probe.cluster));
  checks.push_back(
      CheckReceiveBuffer(config.cluster.receive_buffer_bytes, NumberIn("/proc/sys/net/core/rmem_max")));
  std::error_code error;
  const auto space = std::filesystem::space(".", error);
  checks.push_back(CheckDisk("the current folder", space.available, config.replay.max_disk_bytes + kGiB));
  checks.push_back(CheckFolder("."));
  // An actor with SUMO takes about a quarter of a gibibyte.
  checks.push_back(CheckMemory(AvailableMemory(),
                               config.replay.max_memory_bytes + kGiB * (1.0 + 0.25 * config.actor.count)));
  checks.push_back(CheckCores(UsableCores(), config.learner.threads + config.actor.count));
  checks.push_back(CheckSystemCalls());
  checks.push_back(CheckClock());
  return checks;
}

}  // namespace dadrl
