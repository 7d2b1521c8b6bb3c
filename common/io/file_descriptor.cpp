#include "common/io/file_descriptor.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>

#include "common/io/io_error.h"

namespace dadrl {

Result<FileDescriptor> FileDescriptor::Open(const std::filesystem::path& path, int flags, unsigned mode) {
  int fd = -1;
  do {
    fd = ::open(path.c_str(), flags | O_CLOEXEC, mode);
  } while (fd < 0 && errno == EINTR);
  if (fd < 0) return tl::unexpected<Error>(IoError("open", path, errno));
  return FileDescriptor(fd);
}

void FileDescriptor::Close() {
  // Linux releases the descriptor even when close(2) reports EINTR: a retry could close somebody else's.
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

Status WriteAll(const FileDescriptor& file, std::span<const std::byte> bytes,
                const std::filesystem::path& path) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file.get(), bytes.data(), bytes.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return tl::unexpected<Error>(IoError("write", path, errno));
    }
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
  return {};
}

Status AppendWhole(const FileDescriptor& file, std::span<const std::byte> bytes,
                   const std::filesystem::path& path) {
  const off_t end = ::lseek(file.get(), 0, SEEK_END);
  if (end < 0) return tl::unexpected<Error>(IoError("append to", path, errno));
  Status written = WriteAll(file, bytes, path);
  // The first error is the one to report; when cutting fails as well, the reader's checks catch the rest.
  if (!written) [[maybe_unused]]
    const int cut = ::ftruncate(file.get(), end);
  return written;
}

Status SyncFile(const FileDescriptor& file, const std::filesystem::path& path) {
  while (::fsync(file.get()) != 0) {
    if (errno != EINTR) return tl::unexpected<Error>(IoError("sync", path, errno));
  }
  return {};
}

Status SyncDirectory(const std::filesystem::path& directory) {
  DADRL_ASSIGN_OR_RETURN(const FileDescriptor file, FileDescriptor::Open(directory, O_RDONLY | O_DIRECTORY));
  return SyncFile(file, directory);
}

}  // namespace dadrl
