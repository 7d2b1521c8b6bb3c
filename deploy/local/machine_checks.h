// What `dadrl doctor` looks at: whether this machine can run a cluster, and how to mend what cannot.
#pragma once

#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/util/resources.h"

namespace dadrl {

enum class CheckState {
  kGood,
  kWarning,  // works, but slower or not across machines
  kBroken,   // something needed is missing
};

struct MachineCheck {
  std::string name;
  CheckState state = CheckState::kGood;
  std::string detail;  // what was found
  std::string remedy;  // empty when good
};

// Runs every check for a cluster of `config`; takes a few seconds (starts programs, waits for a multicast).
std::vector<MachineCheck> CheckMachine(const Config& config);

// The single checks, with what they look at passed in.
MachineCheck CheckReceiveBuffer(int64_t wanted_bytes, int64_t system_limit_bytes);
MachineCheck CheckDisk(const std::string& folder, double free_bytes, double wanted_bytes);
MachineCheck CheckMemory(const UsableMemory& memory, double wanted_bytes);
MachineCheck CheckCores(int cores, int processes);

}  // namespace dadrl
