#include "common/io/incarnation.h"

#include <algorithm>
#include <charconv>
#include <system_error>

#include "common/io/atomic_file.h"
#include "common/io/read_file.h"
#include "common/util/log.h"

namespace dadrl {
namespace {

constexpr uint64_t kMaxBytes = 64;
// Nanoseconds; in the year 2258.
constexpr uint64_t kMostCredible = 9'100'000'000'000'000'000;

// 0 when there is none.
uint64_t LastIncarnation(const std::filesystem::path& file) {
  const Result<std::string> text = ReadTextFile(file, kMaxBytes);
  uint64_t last = 0;
  if (text) std::from_chars(text->data(), text->data() + text->size(), last);
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
  const Status kept = WriteFileAtomically(file, std::string_view(fmt::format("{}\n", next)));
  if (!kept) spdlog::warn("{}", kept.error().message);
  return next;
}

}  // namespace dadrl
