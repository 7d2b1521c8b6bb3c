#include "common/io/incarnation.h"

#include <algorithm>
#include <system_error>

#include "common/io/number_file.h"
#include "common/util/fault.h"
#include "common/util/log.h"

namespace dadrl {
namespace {

// Nanoseconds; in the year 2258.
constexpr uint64_t kMostCredible = 9'100'000'000'000'000'000;

// 0 when there is none.
uint64_t LastIncarnation(const std::filesystem::path& file) {
  const uint64_t last = ReadNumber(file).value_or(0);
  // A number that no start could follow would make every later process a predecessor.
  if (last <= kMostCredible) return last;
  spdlog::warn("{} holds {}, which is no time: it is passed over", file.string(), last);
  return 0;
}

}  // namespace

uint64_t NextIncarnation(const std::filesystem::path& run_directory, const std::string& name,
                         int64_t wall_time_ns) {
  const std::filesystem::path file = run_directory / "incarnations" / name;
  std::error_code ignored;  // what matters fails below as well
  std::filesystem::create_directories(file.parent_path(), ignored);
  const uint64_t next = std::max(static_cast<uint64_t>(wall_time_ns), LastIncarnation(file) + 1);
  ProcessFaults().Report(FaultKind::kIncarnation, WriteNumber(file, next));
  return next;
}

}  // namespace dadrl
