#include "common/io/file_descriptor.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cassert>
#include <cerrno>

#include "common/io/io_error.h"

namespace dadrl {

namespace {

constexpr unsigned kNewFileMode = 0644;

tl::unexpected<Error> Refused(const std::filesystem::path& path, std::string_view what) {
  return Fail(ErrorCode::kInvalidArgument, "{} is {}: it is neither read nor written; move it away",
              path.string(), what);
}

std::string_view KindOf(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder, a file is needed";
  if (S_ISFIFO(mode)) return "a FIFO, a regular file is needed";
  if (S_ISSOCK(mode)) return "a socket, a regular file is needed";
  return "a device, a regular file is needed";
}

}  // namespace

Result<FileDescriptor> FileDescriptor::Open(const std::filesystem::path& path, int flags, Links links) {
  assert((flags & O_TRUNC) == 0);
  const bool folder = (flags & O_DIRECTORY) != 0;
  // Without O_NONBLOCK a FIFO would hold us up until somebody opens its other end. It changes nothing for a
  // regular file.
  flags |= O_CLOEXEC | O_NONBLOCK | O_NOCTTY;
  if (links == Links::kRefuse && !folder) flags |= O_NOFOLLOW;
  int fd = -1;
  do {
    fd = ::open(path.c_str(), flags, kNewFileMode);
  } while (fd < 0 && errno == EINTR);
  if (fd < 0 && errno == ELOOP && links == Links::kRefuse)
    return Refused(path, "a link, which is not followed");
  if (fd < 0 && errno == ENXIO) return Refused(path, "a FIFO or a socket, a regular file is needed");
  if (fd < 0 && errno == EISDIR) return Refused(path, KindOf(S_IFDIR));
  if (fd < 0) return tl::unexpected<Error>(IoError("open", path, errno));
  FileDescriptor file(fd);
  struct stat info {};
  if (::fstat(fd, &info) != 0) return tl::unexpected<Error>(IoError("open", path, errno));
  if (!folder && !S_ISREG(info.st_mode)) return Refused(path, KindOf(info.st_mode));
  return file;
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
