#include "common/io/read_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "common/io/io_error.h"

namespace dadrl {
namespace {

template <typename Buffer>
Result<Buffer> Read(const std::filesystem::path& path, uint64_t max_bytes, Links links) {
  DADRL_ASSIGN_OR_RETURN(const BoundedFile file, OpenBounded(path, max_bytes, links));
  Buffer content(file.bytes, typename Buffer::value_type{});
  DADRL_ASSIGN_OR_RETURN(const size_t done,
                         ReadUpTo(file.descriptor, std::as_writable_bytes(std::span(content)), path));
  content.resize(done);  // it may have shrunk meanwhile
  return content;
}

}  // namespace

Result<BoundedFile> OpenBounded(const std::filesystem::path& path, uint64_t max_bytes, Links links) {
  DADRL_ASSIGN_OR_RETURN(FileDescriptor file, FileDescriptor::Open(path, O_RDONLY, links));
  struct stat info {};
  if (::fstat(file.get(), &info) != 0) return tl::unexpected<Error>(IoError("read", path, errno));
  const auto size = static_cast<uint64_t>(info.st_size);
  if (size > max_bytes) {
    return Fail(ErrorCode::kExhausted, "{} is {} bytes long, at most {} are read: it is not the right file",
                path.string(), size, max_bytes);
  }
  return BoundedFile{std::move(file), size};
}

Result<size_t> ReadUpTo(const FileDescriptor& file, std::span<std::byte> bytes,
                        const std::filesystem::path& path) {
  size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = ::read(file.get(), bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return tl::unexpected<Error>(IoError("read", path, errno));
    if (count == 0) break;
    done += static_cast<size_t>(count);
  }
  return done;
}

Result<std::vector<std::byte>> ReadFile(const std::filesystem::path& path, uint64_t max_bytes, Links links) {
  return Read<std::vector<std::byte>>(path, max_bytes, links);
}

Result<std::string> ReadTextFile(const std::filesystem::path& path, uint64_t max_bytes, Links links) {
  return Read<std::string>(path, max_bytes, links);
}

}  // namespace dadrl
