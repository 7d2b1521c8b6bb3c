#include "tests/fuzz/harness.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "common/io/checksum.h"
#include "common/util/log.h"

namespace dadrl::fuzz {
namespace {

class GuardedBuffer {
 public:
  GuardedBuffer() {
    const auto page = static_cast<size_t>(sysconf(_SC_PAGESIZE));
    void* memory = mmap(nullptr, kSize + page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    Require(memory != MAP_FAILED);
    end_ = static_cast<std::byte*>(memory) + kSize;
    Require(mprotect(end_, page, PROT_NONE) == 0);
  }
  std::span<std::byte> Copy(std::span<const std::byte> bytes) {
    const size_t size = std::min(bytes.size(), kSize);
    std::byte* begin = end_ - size;
    if (size > 0) std::memcpy(begin, bytes.data(), size);
    return {begin, size};
  }

 private:
  static constexpr size_t kSize = size_t{1} << 20;
  std::byte* end_;
};

}  // namespace

void Require(bool condition) {
  if (!condition) std::abort();
}

bool CheckGuarded(std::span<const std::byte> input) {
  // Refusals are said; millions of them are not wanted.
  [[maybe_unused]] static const bool quiet = (spdlog::set_level(spdlog::level::off), true);
  static GuardedBuffer buffer;
  return Check(buffer.Copy(input));
}

void MendChecksum(std::span<std::byte> bytes) {
  if (bytes.size() < 8) return;
  const uint64_t checksum = Xxh3(bytes.first(bytes.size() - 8));
  std::memcpy(&bytes[bytes.size() - 8], &checksum, 8);
}

std::span<std::byte> MendedIfAsked(std::span<std::byte> input) {
  if (input.empty()) return input;
  const std::span<std::byte> bytes = input.subspan(1);
  if ((input[0] & std::byte{1}) != std::byte{0}) MendChecksum(bytes);
  return bytes;
}

Bytes AskMended(std::span<const std::byte> bytes) {
  Bytes input{std::byte{1}};
  input.insert(input.end(), bytes.begin(), bytes.end());
  return input;
}

}  // namespace dadrl::fuzz
