// A file as memory in which a damaged medium is no crash.
//
// A mapped page that the device cannot deliver, or that lies behind the end of a file that was cut short,
// raises SIGBUS when it is read. Here it reads as zeros instead, and the mapping says that it is damaged: who
// reads looks at that afterwards, and at the checksums of what it read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "common/io/file_descriptor.h"
#include "common/util/result.h"

namespace dadrl {

// For reading; shared with the file. Movable; thread safe. The first one installs the handler of SIGBUS,
// which hands on what is not about these mappings.
class GuardedMapping {
 public:
  // Nothing is mapped.
  GuardedMapping() = default;
  // The first `length` bytes, at least one; they may reach behind the end of a file that is still growing,
  // and are not to be touched there. Needs no descriptor afterwards. `path` is for the error.
  static Result<GuardedMapping> Map(const FileDescriptor& file, uint64_t length,
                                    const std::filesystem::path& path);
  ~GuardedMapping();
  GuardedMapping(GuardedMapping&& other) noexcept;
  GuardedMapping& operator=(GuardedMapping&& other) noexcept;

  std::span<const std::byte> bytes() const { return bytes_; }
  // Whether something in it could not be read: the zeros stay.
  bool damaged() const;
  // From now on damaged() is about what is read from now on: the reader knows what it has got.
  void ForgetDamage();

 private:
  struct Slot;
  struct Registry;
  GuardedMapping(std::span<const std::byte> bytes, Slot* slot) : bytes_(bytes), slot_(slot) {}

  std::span<const std::byte> bytes_;
  Slot* slot_ = nullptr;  // never freed: the handler may look at any time
};

}  // namespace dadrl
