// A page of memory that a process shares with the one that supervises it: its working threads beat there, and
// it says there what goes wrong. No network and no file: nobody else can write to it, and a beat costs
// nanoseconds.
#pragma once

#include <sys/types.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/io/file_descriptor.h"
#include "common/util/clock.h"
#include "common/util/result.h"

namespace dadrl {

// One working thread. Written by that thread, read by the supervisor.
struct alignas(64) BeatRecord {
  static constexpr uint32_t kResting = UINT32_MAX;  // a limit: waits for another thread, which beats itself

  std::atomic<int32_t> thread{0};     // its id in the system; 0: nobody's record
  std::atomic<uint32_t> limit_ms{0};  // how long it may be silent now; 0: as the supervisor sees fit
  std::atomic<uint64_t> beats{0};
  std::array<char, 24> name{};  // ends with a zero; written before `thread`
};

// The page. Zero bytes but for the magic number are a valid one.
struct BeatMemory {
  static constexpr uint64_t kMagic = 0x3142'5441'4544'4144;  // "DADEATB1"
  static constexpr size_t kThreads = 16;

  uint64_t magic = kMagic;
  std::atomic<uint64_t> work{0};           // what the process came to: updates, frames
  std::atomic<uint64_t> paused_ns{0};      // written by the supervisor: how long it kept the process stopped
  std::atomic<uint32_t> fault_version{0};  // odd while `fault` is being written
  std::array<std::atomic<char>, 156> fault{};  // ends with a zero; empty: all is well
  std::array<BeatRecord, kThreads> threads;
};
static_assert(std::atomic<uint64_t>::is_always_lock_free && sizeof(std::atomic<char>) == 1,
              "processes share these");

// The supervisor's end. Not thread safe. Whatever the process writes, reading it is bounded.
class BeatPage {
 public:
  struct Thread {
    pid_t id = 0;
    std::string name;
    uint64_t beats = 0;
    Duration limit{};      // zero: as the supervisor sees fit
    bool resting = false;  // its silence means nothing
  };

  // kExhausted: no memory, or no descriptor for it.
  static Result<BeatPage> Create();

  // To be inherited by the process, with its number in kBeatsVariable.
  int fd() const { return file_.get(); }
  // The threads that have begun to work and have not ended.
  std::vector<Thread> Threads() const;
  uint64_t work() const { return memory_->work.load(std::memory_order_relaxed); }
  // What holds the process up, one line; empty when nothing does.
  std::string Fault() const;
  void AddPause(Duration paused);

 private:
  struct Unmap {
    void operator()(BeatMemory* memory) const;
  };
  BeatPage(FileDescriptor file, BeatMemory* memory) : file_(std::move(file)), memory_(memory) {}

  FileDescriptor file_;
  std::unique_ptr<BeatMemory, Unmap> memory_;
};

// The process's end: the page it inherited, or one of its own where nobody supervises it. Lives for ever.
BeatMemory& BeatMemoryOfThisProcess();

}  // namespace dadrl
