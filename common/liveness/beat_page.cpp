#include "common/liveness/beat_page.h"

#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <new>
#include <optional>

#include "common/io/unnamed_file.h"
#include "common/util/environment.h"

namespace dadrl {
namespace {

BeatMemory* Map(int fd) {
  void* const memory = mmap(nullptr, sizeof(BeatMemory), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  return memory == MAP_FAILED ? nullptr : static_cast<BeatMemory*>(memory);
}

// The inherited page. The variable is input from outside: a descriptor that is not a page of ours is not
// touched.
BeatMemory* Inherited() {
  const std::optional<std::string> text = FromEnvironment(kBeatsVariable);
  if (!text) return nullptr;
  int fd = -1;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), fd);
  if (error != std::errc() || end != text->data() + text->size() || fd <= STDERR_FILENO) return nullptr;
  struct stat status {};
  uint64_t magic = 0;
  if (fstat(fd, &status) != 0 || status.st_size != sizeof(BeatMemory)) return nullptr;
  if (pread(fd, &magic, sizeof magic, 0) != sizeof magic || magic != BeatMemory::kMagic) return nullptr;
  const FileDescriptor file(fd);  // closed once it is mapped: our own children have none
  return Map(fd);
}

}  // namespace

void BeatPage::Unmap::operator()(BeatMemory* memory) const { munmap(memory, sizeof(BeatMemory)); }

Result<BeatPage> BeatPage::Create() {
  DADRL_ASSIGN_OR_RETURN(FileDescriptor file, OpenUnnamedFile("beats"));
  BeatMemory* const memory = ftruncate(file.get(), sizeof(BeatMemory)) == 0 ? Map(file.get()) : nullptr;
  if (memory == nullptr) {
    return Fail(ErrorCode::kExhausted, "no memory for a page of {} bytes: {}", sizeof(BeatMemory),
                std::strerror(errno));
  }
  return BeatPage(std::move(file), new (memory) BeatMemory);
}

std::vector<BeatPage::Thread> BeatPage::Threads() const {
  std::vector<Thread> threads;
  for (const BeatRecord& record : memory_->threads) {
    const pid_t id = record.thread.load(std::memory_order_acquire);
    if (id <= 0) continue;
    const uint32_t limit_ms = record.limit_ms.load(std::memory_order_relaxed);
    threads.push_back(
        {.id = id,
         .name = std::string(record.name.data(), strnlen(record.name.data(), record.name.size())),
         .beats = record.beats.load(std::memory_order_relaxed),
         .limit = std::chrono::milliseconds(limit_ms),
         .resting = limit_ms == BeatRecord::kResting});
  }
  return threads;
}

std::string BeatPage::Fault() const {
  const auto read = [this] {
    std::string text;
    for (const std::atomic<char>& c : memory_->fault) {
      const char value = c.load(std::memory_order_relaxed);
      if (value == '\0') break;
      text += value;
    }
    return text;
  };
  // A word that keeps changing under our eyes is read at the next look.
  for (int attempt = 0; attempt < 3; ++attempt) {
    const uint32_t version = memory_->fault_version.load(std::memory_order_acquire);
    std::string text = read();
    std::atomic_thread_fence(std::memory_order_acquire);
    const bool unchanged = memory_->fault_version.load(std::memory_order_relaxed) == version;
    if (version % 2 == 0 && unchanged) return text;
  }
  return {};
}

void BeatPage::AddPause(Duration paused) {
  memory_->paused_ns.fetch_add(static_cast<uint64_t>(paused.count()), std::memory_order_relaxed);
}

BeatMemory& BeatMemoryOfThisProcess() {
  static BeatMemory own;
  static BeatMemory* const memory = [] {
    BeatMemory* const inherited = Inherited();
    return inherited != nullptr ? inherited : &own;
  }();
  return *memory;
}

}  // namespace dadrl
