// Files of values and lengths that end in a checksum, read in order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/io/byte_io.h"
#include "common/io/checksum.h"
#include "common/io/read_file.h"
#include "common/util/result.h"

namespace dadrl {

// What a kind of file begins with: its magic, then u32 format.
struct FileKind {
  std::string_view magic;
  std::string_view name;  // "a checkpoint"
  uint32_t oldest = 1;    // format that is still read
  uint32_t format = 1;    // that is written
  std::string_view remedy;

  void PutHead(ByteWriter& writer) const {
    writer.PutBytes(std::as_bytes(std::span(magic)));
    writer.Put(format);
  }
};

// Little-endian values from a file that ends in the xxh3-64 of everything before. A length that the file
// gives is believed, and memory taken for it, only as far as bytes are left. After the first read that does
// not fit, ok() is false and every value is zero or empty: ask CheckEnd once, at the end, before anything
// that was read is believed. Each read may block on the disk. Not thread safe.
class FileReader {
 public:
  // Errors as of ReadFile, and nothing is read then.
  static Result<FileReader> Open(const std::filesystem::path& path, uint64_t max_bytes,
                                 Links links = Links::kRefuse);

  // The format, to be read first: a file that never was of this kind is called so, not damaged. kCorrupt,
  // with the remedy: of another kind. kInvalidArgument: of a format that is not read.
  Result<uint32_t> GetHead(const FileKind& kind);
  template <typename T>
  requires std::is_arithmetic_v<T> T Get() {
    T value{};
    Read(std::as_writable_bytes(std::span(&value, 1)));
    return value;
  }
  // u32 length, then the bytes.
  std::string GetText() {
    std::string text(Fitting(Get<uint32_t>(), 1), '\0');
    Read(std::as_writable_bytes(std::span(text)));
    return text;
  }
  // `count` values.
  template <typename T>
  std::vector<T> GetVector(uint64_t count) {
    std::vector<T> values(Fitting(count, sizeof(T)));
    Read(std::as_writable_bytes(std::span(values)));
    return values;
  }
  // u64 count, then the values.
  template <typename T>
  std::vector<T> GetVector() {
    return GetVector<T>(Get<uint64_t>());
  }

  bool ok() const { return ok_; }
  uint64_t file_bytes() const { return file_.bytes; }

  // Reads the checksum. kCorrupt, with `remedy`, when a read did not fit, something else is left, or the
  // bytes are not those that were written; kInternal when the disk failed.
  Status CheckEnd(std::string_view remedy);

 private:
  FileReader(BoundedFile file, std::filesystem::path path)
      : file_(std::move(file)), path_(std::move(path)), left_(file_.bytes) {}
  // `count` where so many values of `size` bytes are left, else 0.
  size_t Fitting(uint64_t count, size_t size);
  // Fills `bytes`; with zeros when they do not fit.
  void Read(std::span<std::byte> bytes);

  BoundedFile file_;
  std::filesystem::path path_;
  uint64_t left_;  // bytes
  Xxh3Stream hash_;
  bool ok_ = true;
  Status disk_;
};

}  // namespace dadrl
