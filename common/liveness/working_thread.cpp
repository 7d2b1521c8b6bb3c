#include "common/liveness/working_thread.h"

#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>

#include "common/util/mutex.h"

namespace dadrl {
namespace {

thread_local BeatRecord* current = nullptr;

BeatRecord* Claim() {
  for (BeatRecord& record : BeatMemoryOfThisProcess().threads) {
    int32_t nobody = 0;
    // Below zero: taken, but not yet to be looked at.
    if (record.thread.compare_exchange_strong(nobody, -1)) return &record;
  }
  return nullptr;
}

uint32_t SetLimit(uint32_t limit_ms) {
  return current == nullptr ? 0 : current->limit_ms.exchange(limit_ms, std::memory_order_relaxed);
}

uint32_t Milliseconds(Duration limit) {
  const auto whole = std::chrono::duration_cast<std::chrono::milliseconds>(limit).count();
  return static_cast<uint32_t>(std::clamp<int64_t>(whole, 1, BeatRecord::kResting - 1));
}

}  // namespace

WorkingThread::WorkingThread(std::string_view name) : record_(Claim()), outer_(current) {
  if (record_ == nullptr) return;
  const size_t length = std::min(name.size(), record_->name.size() - 1);
  std::copy_n(name.data(), length, record_->name.data());
  record_->name[length] = '\0';
  record_->limit_ms.store(0, std::memory_order_relaxed);
  current = record_;
  Beat();
  record_->thread.store(static_cast<int32_t>(syscall(SYS_gettid)), std::memory_order_release);
}

WorkingThread::~WorkingThread() {
  current = outer_;
  if (record_ != nullptr) record_->thread.store(0, std::memory_order_release);
}

void Beat() {
  // The only writer: no need for an atomic increment.
  if (current == nullptr) return;
  current->beats.store(current->beats.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

LongWork::LongWork(Duration limit) : LongWork(Milliseconds(limit)) {}

LongWork::LongWork(uint32_t limit_ms) : outer_limit_ms_(SetLimit(limit_ms)) { Beat(); }

LongWork::~LongWork() {
  Beat();
  SetLimit(outer_limit_ms_);
}

void ReportWork(uint64_t total) { BeatMemoryOfThisProcess().work.store(total, std::memory_order_relaxed); }

void ReportFault(std::string_view what) {
  static Mutex mutex;
  MutexLock lock(mutex);
  BeatMemory& memory = BeatMemoryOfThisProcess();
  memory.fault_version.fetch_add(1, std::memory_order_relaxed);
  std::atomic_thread_fence(std::memory_order_release);
  for (size_t i = 0; i < memory.fault.size(); ++i) {
    const char value = i < what.size() && i + 1 < memory.fault.size() ? what[i] : '\0';
    memory.fault[i].store(value == '\n' ? ' ' : value, std::memory_order_relaxed);
  }
  memory.fault_version.fetch_add(1, std::memory_order_release);
}

Duration PausedTime() {
  return Duration(static_cast<int64_t>(BeatMemoryOfThisProcess().paused_ns.load(std::memory_order_relaxed)));
}

}  // namespace dadrl
