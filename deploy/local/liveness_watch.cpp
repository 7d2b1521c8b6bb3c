#include "deploy/local/liveness_watch.h"

#include <fmt/format.h>
#include <fmt/os.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "common/liveness/stack_dump.h"
#include "deploy/local/thread_times.h"

namespace dadrl {
namespace {

constexpr Duration kLookInterval = std::chrono::milliseconds(200);

std::optional<BeatPage> MakePage() {
  Result<BeatPage> page = BeatPage::Create();
  if (!page) return std::nullopt;
  return std::move(*page);
}

std::string FirstLineOf(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  return line;
}

// Sent to a process that has no handler for it, the signal would kill it.
bool Handles(pid_t process, int signal_number) {
  std::ifstream status(fmt::format("/proc/{}/status", process));
  for (std::string key; status >> key;) {
    uint64_t caught = 0;
    if (key == "SigCgt:" && status >> std::hex >> caught) return (caught >> (signal_number - 1) & 1) != 0;
    status.ignore(4096, '\n');
  }
  return false;
}

}  // namespace

LivenessWatch::LivenessWatch(const HangLimits& limits, TimePoint now)
    : page_(MakePage()), watch_(limits, now), next_look_(now) {}

std::optional<std::string> LivenessWatch::Look(pid_t process, TimePoint now) {
  if (!page_ || now < next_look_) return std::nullopt;
  next_look_ = now + kLookInterval;
  return watch_.Look(now, page_->Threads(), [process] { return ReadThreadTimes(process); });
}

void LivenessWatch::AddPause(Duration paused) {
  if (page_) page_->AddPause(paused);
}

void DumpThreads(pid_t process, const std::filesystem::path& log) {
  const bool handles = Handles(process, StackDumpSignal());
  std::ofstream out(log, std::ios::app);
  out << fmt::format("{} hangs; its threads:\n", process);
  const std::vector<ThreadTimes> threads = ReadThreadTimes(process);
  for (const ThreadTimes& thread : threads) {
    const std::filesystem::path task = fmt::format("/proc/{}/task/{}", process, thread.id);
    out << fmt::format("  thread {} ({}): state {}, waits in {}, ran {:.1f} s\n", thread.id,
                       FirstLineOf(task / "comm"), thread.state, FirstLineOf(task / "wchan"),
                       ToSeconds(thread.ran));
  }
  out.close();
  for (const ThreadTimes& thread : threads) {
    if (handles) syscall(SYS_tgkill, process, thread.id, StackDumpSignal());
  }
}

}  // namespace dadrl
