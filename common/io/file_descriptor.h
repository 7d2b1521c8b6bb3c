// An open file that closes itself, and the two calls that a plain write(2) needs around it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <utility>

#include "common/util/result.h"

namespace dadrl {

// What to do with a path whose last part is a symbolic link. Files that are ours (in a run, a snapshot, a
// replay) are never links, so one there was put there by somebody else; a user may name a file by a link.
enum class Links { kRefuse, kFollow };

// Owns a descriptor; -1 is none. Not thread safe.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  explicit FileDescriptor(int fd) : fd_(fd) {}
  ~FileDescriptor() { Close(); }
  FileDescriptor(FileDescriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }

  // open(2) with O_CLOEXEC; `flags` and `mode` as there. Only a regular file, or with O_DIRECTORY a folder: a
  // FIFO, a socket or a device is kInvalidArgument, at once and unchanged; so is a link where `links`
  // refuses. Not for O_TRUNC, which would change what is refused.
  static Result<FileDescriptor> Open(const std::filesystem::path& path, int flags,
                                     Links links = Links::kRefuse);

  int get() const { return fd_; }
  bool valid() const { return fd_ >= 0; }
  void Close();

 private:
  int fd_ = -1;
};

// Writes all of `bytes` at the descriptor's position, through short writes and interruptions. `path` is for
// the error text. Blocks on the disk.
Status WriteAll(const FileDescriptor& file, std::span<const std::byte> bytes,
                const std::filesystem::path& path);

// Appends all of `bytes` or nothing: a write that fails in the middle is cut off again. For files opened with
// O_APPEND that only this descriptor writes.
Status AppendWhole(const FileDescriptor& file, std::span<const std::byte> bytes,
                   const std::filesystem::path& path);

// Forces what was written (or, for a folder, the names in it) to the device. Blocks on the disk.
Status SyncFile(const FileDescriptor& file, const std::filesystem::path& path);
Status SyncDirectory(const std::filesystem::path& directory);

}  // namespace dadrl
