#include "common/util/process_setup.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <new>
#include <string_view>

namespace dadrl {
namespace {

using Line = std::array<char, 256>;

// Without an allocation: there may be no memory for one.
std::string_view WriteText(Line& line, const std::exception& exception) {
  if (dynamic_cast<const std::bad_alloc*>(&exception) == nullptr) {
    const auto end = fmt::format_to_n(line.begin(), line.size(), "unexpected: {}", exception.what());
    return {line.data(), std::min(end.size, line.size())};
  }
  rlimit limit{};
  getrlimit(RLIMIT_AS, &limit);
  constexpr std::string_view kRemedy = "lower replay.max_memory_bytes or actor.count";
  const auto end =
      limit.rlim_cur == RLIM_INFINITY
          ? fmt::format_to_n(line.begin(), line.size(), "out of memory on this machine or in its cgroup: {}",
                             kRemedy)
          : fmt::format_to_n(line.begin(), line.size(),
                             "out of memory: this process may use {} KiB; raise that (ulimit -v), or {}",
                             limit.rlim_cur / 1024, kRemedy);
  return {line.data(), std::min(end.size, line.size())};
}

[[noreturn]] void EndWithASentence() {
  Line line{};
  std::string_view text = "unexpected end";
  try {
    if (const std::exception_ptr thrown = std::current_exception()) std::rethrow_exception(thrown);
  } catch (const std::exception& exception) {
    text = WriteText(line, exception);
  } catch (...) {
    text = "unexpected: an exception of an unknown kind";
  }
  [[maybe_unused]] ssize_t written = write(STDERR_FILENO, text.data(), text.size());
  written = write(STDERR_FILENO, "\n", 1);
  _exit(1);
}

}  // namespace

void SetUpProcess() {
  rlimit descriptors{};
  if (getrlimit(RLIMIT_NOFILE, &descriptors) == 0 && descriptors.rlim_cur < descriptors.rlim_max) {
    descriptors.rlim_cur = descriptors.rlim_max;
    setrlimit(RLIMIT_NOFILE, &descriptors);  // with fewer it works as well
  }
  std::signal(SIGXFSZ, SIG_IGN);
  std::set_terminate(EndWithASentence);
}

std::string ExceptionText(const std::exception& exception) {
  Line line{};
  return std::string(WriteText(line, exception));
}

}  // namespace dadrl
