// Little-endian values and length-prefixed text in byte buffers: the building block of our file formats.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace dadrl {

static_assert(std::endian::native == std::endian::little, "files and messages are little endian");

// Appends to a buffer that it borrows.
class ByteWriter {
 public:
  explicit ByteWriter(std::vector<std::byte>& out) : out_(out) {}

  template <typename T>
  requires std::is_arithmetic_v<T>
  void Put(T value) { PutBytes(std::as_bytes(std::span(&value, 1))); }
  void PutBytes(std::span<const std::byte> bytes);
  // u32 length, then the bytes.
  void PutText(std::string_view text) {
    Put<uint32_t>(text.size());
    PutBytes(std::as_bytes(std::span(text)));
  }

 private:
  std::vector<std::byte>& out_;
};

// Reads from bytes that it borrows; never beyond their end. After the first read that does not fit, ok() is
// false and every value is zero or empty: check it once, at the end.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <typename T>
  requires std::is_arithmetic_v<T> T Get() {
    T value{};
    const std::span<const std::byte> bytes = GetBytes(sizeof(T));
    if (ok_) std::memcpy(&value, bytes.data(), sizeof(T));
    return value;
  }
  std::span<const std::byte> GetBytes(uint64_t count) {
    if (!ok_ || count > rest_.size()) {
      ok_ = false;
      return {};
    }
    const std::span<const std::byte> bytes = rest_.first(count);
    rest_ = rest_.subspan(count);
    return bytes;
  }
  std::string GetText() {
    const std::span<const std::byte> bytes = GetBytes(Get<uint32_t>());
    return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }

  bool ok() const { return ok_; }
  size_t remaining() const { return rest_.size(); }

 private:
  std::span<const std::byte> rest_;
  bool ok_ = true;
};

}  // namespace dadrl
