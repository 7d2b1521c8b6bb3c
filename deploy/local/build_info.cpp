#include "deploy/local/build_info.h"

#include <fmt/format.h>

#include <fstream>

#include "commit.h"
#include "common/util/resources.h"

namespace dadrl {
namespace {

// The first "model name : ..." of /proc/cpuinfo, as x86 has it.
std::string ProcessorName() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const size_t value = line.find(": ");
    if (line.starts_with("model name") && value != std::string::npos) return line.substr(value + 2);
  }
  return "unknown processor";
}

}  // namespace

std::string BuildCommit() { return DADRL_COMMIT; }

std::string MachineName() { return fmt::format("{}, {} cores", ProcessorName(), UsableCores()); }

}  // namespace dadrl
