#include "deploy/local/build_info.h"

#include <fmt/format.h>

#include <thread>

#include "commit.h"
#include "common/io/read_file.h"

namespace dadrl {
namespace {

constexpr uint64_t kMaxBytes = uint64_t{16} << 20;

// The first "model name : ..." of /proc/cpuinfo.
std::string ProcessorName() {
  const auto info = ReadTextFile("/proc/cpuinfo", kMaxBytes);
  if (!info) return "unknown processor";
  const size_t key = info->find("model name");
  const size_t begin = key == std::string::npos ? key : info->find(": ", key);
  if (begin == std::string::npos) return "unknown processor";
  return info->substr(begin + 2, info->find('\n', begin) - begin - 2);
}

}  // namespace

std::string BuildCommit() { return DADRL_COMMIT; }

std::string MachineName() {
  return fmt::format("{}, {} cores", ProcessorName(), std::thread::hardware_concurrency());
}

}  // namespace dadrl
