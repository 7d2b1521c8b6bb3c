// xxh3-64: the checksum of every file and message of ours. Finds damage, not malice.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace dadrl {

uint64_t Xxh3(std::span<const std::byte> bytes);

// How a file or message of ours ends: the checksum of everything before, little endian.
inline constexpr size_t kChecksumBytes = 8;
void AppendChecksum(std::vector<std::byte>& bytes);
// What stands before the checksum; nothing where `bytes` are too few or not those that it was appended to.
std::optional<std::span<const std::byte>> CheckedContent(std::span<const std::byte> bytes);

// The same over bytes that come in pieces. Not thread safe.
class Xxh3Stream {
 public:
  Xxh3Stream();
  ~Xxh3Stream();
  Xxh3Stream(Xxh3Stream&&) noexcept;
  void Add(std::span<const std::byte> bytes);
  // Of everything added so far.
  uint64_t Digest() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace dadrl
