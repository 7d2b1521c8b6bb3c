// Arrays as files that NumPy reads and writes: .npy,
// numpy.org/doc/stable/reference/generated/numpy.lib.format.html. Row-major, little endian, numbers only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "common/util/result.h"

namespace dadrl {

// NumPy's name of a number type: "<f4", "|u1", "<i8", ...
template <typename T>
requires std::is_arithmetic_v<T> std::string NpyType() {
  const char kind = std::is_floating_point_v<T> ? 'f' : std::is_signed_v<T> ? 'i' : 'u';
  return fmt::format("{}{}{}", sizeof(T) == 1 ? '|' : '<', kind, sizeof(T));
}

// What stands before the numbers (format 1.0, padded to 64 bytes): for a writer that appends the numbers
// itself.
std::string NpyHeader(std::string_view type, std::span<const size_t> shape);

// Atomic and durable. `values` has as many numbers as `shape` says. Blocks on the disk.
Status WriteNpyBytes(const std::filesystem::path& path, std::string_view type, std::span<const size_t> shape,
                     std::span<const std::byte> values);

template <typename T>
Status WriteNpy(const std::filesystem::path& path, std::span<const size_t> shape, std::span<const T> values) {
  return WriteNpyBytes(path, NpyType<T>(), shape, std::as_bytes(values));
}

template <typename T>
struct NpyArray {
  std::vector<size_t> shape;  // empty: one number
  std::vector<T> values;
};

struct NpyBytes {
  std::vector<size_t> shape;
  std::vector<std::byte> file;        // the whole file
  std::span<const std::byte> values;  // the part of `file` behind the header
};

// The shape and the numbers of a .npy file that is in memory; `path` is for the error. Errors as
// ReadNpyBytes.
struct NpyView {
  std::vector<size_t> shape;
  std::span<const std::byte> values;
};
Result<NpyView> ParseNpy(std::span<const std::byte> file, std::string_view type,
                         const std::filesystem::path& path);

// kNotFound without a file, kExhausted when it is longer than `max_bytes`, kCorrupt when it is damaged or no
// .npy file, kInvalidArgument when it holds another type or is column-major (remedy in the message). Formats
// 1 to 3. Blocks on the disk.
Result<NpyBytes> ReadNpyBytes(const std::filesystem::path& path, std::string_view type, uint64_t max_bytes);

template <typename T>
Result<NpyArray<T>> ReadNpy(const std::filesystem::path& path, uint64_t max_bytes) {
  DADRL_ASSIGN_OR_RETURN(const NpyBytes bytes, ReadNpyBytes(path, NpyType<T>(), max_bytes));
  NpyArray<T> array{.shape = bytes.shape, .values = std::vector<T>(bytes.values.size() / sizeof(T))};
  if (!array.values.empty()) std::memcpy(array.values.data(), bytes.values.data(), bytes.values.size());
  return array;
}

// (3, 6, 5, 7) as NumPy prints it.
std::string ShapeText(std::span<const size_t> shape);

}  // namespace dadrl
