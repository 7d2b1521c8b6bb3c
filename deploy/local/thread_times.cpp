#include "deploy/local/thread_times.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string>

namespace dadrl {
namespace {

// "PID (name) STATE ...": the name may hold anything, also parentheses.
std::optional<char> StateIn(const std::filesystem::path& stat) {
  std::ifstream stream(stat);
  std::string line;
  std::getline(stream, line);
  const size_t name_end = line.rfind(") ");
  if (name_end == std::string::npos || name_end + 2 >= line.size()) return std::nullopt;
  return line[name_end + 2];
}

std::optional<ThreadTimes> Read(pid_t id, const std::filesystem::path& thread) {
  const std::optional<char> state = StateIn(thread / "stat");
  if (!state) return std::nullopt;
  ThreadTimes times{.id = id, .state = *state};
  std::ifstream schedule(thread / "schedstat");
  int64_t ran = 0;
  int64_t waited = 0;
  if (schedule >> ran >> waited) {
    times.ran = Duration(ran);
    times.waited = Duration(waited);
  }
  return times;
}

}  // namespace

std::vector<ThreadTimes> ReadThreadTimes(pid_t process, const std::filesystem::path& proc) {
  std::vector<ThreadTimes> times;
  std::error_code gone;
  const std::filesystem::path tasks = proc / fmt::format("{}", process) / "task";
  for (std::filesystem::directory_iterator entry(tasks, gone), end; !gone && entry != end;
       entry.increment(gone)) {
    const std::string name = entry->path().filename().string();
    pid_t id = 0;
    std::from_chars(name.data(), name.data() + name.size(), id);
    if (const auto thread = Read(id, entry->path())) times.push_back(*thread);
  }
  std::stable_partition(times.begin(), times.end(),
                        [process](const ThreadTimes& thread) { return thread.id == process; });
  return times;
}

}  // namespace dadrl
