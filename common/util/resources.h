// How much of the machine this process may use: what its affinity and its cgroup (a container, a batch job)
// leave of it.
#pragma once

#include <filesystem>
#include <string>

namespace dadrl {

// Where the system says so; elsewhere in tests.
struct SystemFolders {
  std::filesystem::path proc = "/proc";
  std::filesystem::path cgroup = "/sys/fs/cgroup";
};

// Whole cores, at least 1: the least of what the affinity of this thread (taskset), and the quota of its
// cgroup and those around it, allow. A quota of one and a half cores is one.
int UsableCores(const SystemFolders& system = {});

struct UsableMemory {
  double bytes = 0.0;      // that can be had now; 0 where nobody knows
  bool of_cgroup = false;  // the cgroup's limit is tighter than the machine
};
// The least of what the machine has available and what the limits of the cgroup, and of those around it,
// leave.
UsableMemory AvailableMemory(const SystemFolders& system = {});

}  // namespace dadrl
