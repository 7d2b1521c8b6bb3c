#include "common/util/resources.h"

#include <sched.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <thread>
#include <vector>

namespace dadrl {
namespace {

namespace fs = std::filesystem;

// The first number in a file; nothing for "max" and for a file that is not there.
std::optional<double> NumberIn(const fs::path& file) {
  std::ifstream stream(file);
  double value = 0.0;
  if (stream >> value) return value;
  return std::nullopt;
}

// The number behind `key` in a file of "key number" lines.
double ValueOf(const fs::path& file, const std::string& key) {
  std::ifstream stream(file);
  for (std::string word; stream >> word;) {
    double value = 0.0;
    if (stream >> value && word == key) return value;
    stream.clear();
    stream.ignore(256, '\n');
  }
  return 0.0;
}

// The folders of this process's cgroup and those around it, the innermost first. `controller` is one of
// version 1 ("memory"), or empty for the one tree of version 2. What a container does not see is left out.
std::vector<fs::path> CgroupFolders(const SystemFolders& system, const std::string& controller) {
  std::ifstream stream(system.proc / "self" / "cgroup");
  for (std::string line; std::getline(stream, line);) {  // "4:cpu,cpuacct:/path", "0::/path"
    const size_t first = line.find(':');
    const size_t second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    std::stringstream controllers(line.substr(first + 1, second - first - 1));
    bool ours = controller.empty() && first + 1 == second;
    for (std::string name; std::getline(controllers, name, ',');) ours = ours || name == controller;
    if (!ours) continue;
    const fs::path root = controller.empty() ? system.cgroup : system.cgroup / controller;
    std::vector<fs::path> folders;
    for (fs::path path = fs::path(line.substr(second + 1)).relative_path(); !path.empty();
         path = path.parent_path()) {
      folders.push_back(root / path);
    }
    folders.push_back(root);
    return folders;
  }
  return {};
}

int CoresOfAffinity() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) == 0) return CPU_COUNT(&set);
  return static_cast<int>(std::thread::hardware_concurrency());  // more cores than the set has room for
}

// Version 2: "200000 100000" or "max 100000".
std::optional<double> CoresOfCpuMax(const fs::path& file) {
  std::ifstream stream(file);
  double quota = 0.0;
  double period = 0.0;
  if (stream >> quota >> period && quota > 0.0 && period > 0.0) return quota / period;
  return std::nullopt;
}

std::optional<double> CoresOfQuota(const fs::path& folder) {
  const auto quota = NumberIn(folder / "cpu.cfs_quota_us");
  const auto period = NumberIn(folder / "cpu.cfs_period_us");
  if (!quota || !period || *quota <= 0.0 || *period <= 0.0) return std::nullopt;
  return *quota / *period;
}

// What a limit leaves: used pages that the kernel can drop at once are free.
std::optional<double> Left(const fs::path& folder, const char* limit, const char* used, const char* cache) {
  const auto bytes = NumberIn(folder / limit);
  if (!bytes) return std::nullopt;
  const double taken = NumberIn(folder / used).value_or(0.0) - ValueOf(folder / "memory.stat", cache);
  return std::max(0.0, *bytes - std::max(0.0, taken));
}

}  // namespace

int UsableCores(const SystemFolders& system) {
  double cores = CoresOfAffinity();
  for (const fs::path& folder : CgroupFolders(system, "")) {
    cores = std::min(cores, CoresOfCpuMax(folder / "cpu.max").value_or(cores));
  }
  for (const fs::path& folder : CgroupFolders(system, "cpu")) {
    cores = std::min(cores, CoresOfQuota(folder).value_or(cores));
  }
  return std::max(1, static_cast<int>(std::floor(cores)));
}

UsableMemory AvailableMemory(const SystemFolders& system) {
  constexpr double kKiB = 1024.0;
  UsableMemory memory{.bytes = kKiB * ValueOf(system.proc / "meminfo", "MemAvailable:")};
  const auto limit = [&](std::optional<double> left) {
    if (!left || (memory.bytes > 0.0 && *left >= memory.bytes)) return;
    memory = {.bytes = *left, .of_cgroup = true};
  };
  for (const fs::path& folder : CgroupFolders(system, "")) {
    limit(Left(folder, "memory.max", "memory.current", "inactive_file"));
  }
  for (const fs::path& folder : CgroupFolders(system, "memory")) {
    limit(Left(folder, "memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"));
  }
  return memory;
}

}  // namespace dadrl
