#include "common/io/guarded_mapping.h"

#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <utility>
#include <vector>

#include "common/io/io_error.h"
#include "common/util/mutex.h"

namespace dadrl {

struct GuardedMapping::Slot {
  std::atomic<uintptr_t> begin{0};
  std::atomic<uintptr_t> end{0};
  std::atomic<bool> damaged{false};
};

// Slots in blocks that are never freed, so that the handler needs no lock.
struct GuardedMapping::Registry {
  struct Block {
    std::array<Slot, 256> slots;
    std::atomic<Block*> next{nullptr};
  };

  static Registry& Get() {
    static Registry* const registry = new Registry;  // outlives every mapping, static ones included
    return *registry;
  }
  Registry();
  Slot* Take(std::span<const std::byte> bytes) DADRL_EXCLUDES(mutex) {
    MutexLock lock(mutex);
    if (free.empty()) AddBlock();
    Slot* const slot = free.back();
    free.pop_back();
    slot->damaged.store(false);
    const auto begin = reinterpret_cast<uintptr_t>(bytes.data());
    slot->end.store(begin + bytes.size());
    slot->begin.store(begin);
    return slot;
  }
  void Return(Slot* slot) DADRL_EXCLUDES(mutex) {
    slot->end.store(0);
    slot->begin.store(0);
    MutexLock lock(mutex);
    free.push_back(slot);
  }
  // The mapping that holds `address`; callable from the handler.
  Slot* Find(uintptr_t address) {
    for (Block* block = newest.load(); block != nullptr; block = block->next.load()) {
      for (Slot& slot : block->slots) {
        if (address >= slot.begin.load() && address < slot.end.load()) return &slot;
      }
    }
    return nullptr;
  }
  void AddBlock() DADRL_REQUIRES(mutex) {
    auto* const block = new Block;
    block->next.store(newest.load());
    for (Slot& slot : block->slots) free.push_back(&slot);
    newest.store(block);
  }
  static void OnBusError(int signal, siginfo_t* info, void* context);

  const uintptr_t page = static_cast<uintptr_t>(sysconf(_SC_PAGESIZE));
  struct sigaction before {};
  std::atomic<Block*> newest{nullptr};
  Mutex mutex;
  std::vector<Slot*> free DADRL_GUARDED_BY(mutex);
};

GuardedMapping::Registry::Registry() {
  struct sigaction action {};
  action.sa_sigaction = OnBusError;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  sigemptyset(&action.sa_mask);
  sigaction(SIGBUS, &action, &before);
}

// Only system calls and lock-free atomics in here.
void GuardedMapping::Registry::OnBusError(int, siginfo_t* info, void*) {
  Registry& registry = Get();
  const auto address = reinterpret_cast<uintptr_t>(info->si_addr);
  Slot* const slot = registry.Find(address);
  void* const page = reinterpret_cast<void*>(address / registry.page * registry.page);
  const int error = errno;
  const bool mended = slot != nullptr && mmap(page, registry.page, PROT_READ,
                                              MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED, -1, 0) != MAP_FAILED;
  errno = error;
  if (mended) {
    slot->damaged.store(true);
  } else {
    sigaction(SIGBUS, &registry.before, nullptr);  // the instruction faults again, into what was there before
  }
}

Result<GuardedMapping> GuardedMapping::Map(const FileDescriptor& file, uint64_t length,
                                           const std::filesystem::path& path) {
  Registry& registry = Registry::Get();
  void* const memory = mmap(nullptr, length, PROT_READ, MAP_SHARED, file.get(), 0);
  if (memory == MAP_FAILED) return tl::unexpected(IoError("map", path, errno));
  const std::span bytes(static_cast<const std::byte*>(memory), length);
  return GuardedMapping(bytes, registry.Take(bytes));
}

GuardedMapping::~GuardedMapping() {
  if (slot_ == nullptr) return;
  Registry::Get().Return(slot_);
  munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

GuardedMapping::GuardedMapping(GuardedMapping&& other) noexcept
    : bytes_(std::exchange(other.bytes_, {})), slot_(std::exchange(other.slot_, nullptr)) {}

GuardedMapping& GuardedMapping::operator=(GuardedMapping&& other) noexcept {
  std::swap(bytes_, other.bytes_);
  std::swap(slot_, other.slot_);
  return *this;
}

bool GuardedMapping::damaged() const { return slot_ != nullptr && slot_->damaged.load(); }

void GuardedMapping::ForgetDamage() {
  if (slot_ != nullptr) slot_->damaged.store(false);
}

}  // namespace dadrl
