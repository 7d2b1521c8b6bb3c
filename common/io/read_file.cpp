#include "common/io/read_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "common/io/file_descriptor.h"
#include "common/io/io_error.h"

namespace dadrl {
namespace {

template <typename Buffer>
Result<Buffer> Read(const std::filesystem::path& path, uint64_t max_bytes, Links links) {
  DADRL_ASSIGN_OR_RETURN(const FileDescriptor file, FileDescriptor::Open(path, O_RDONLY, links));
  struct stat info {};
  if (::fstat(file.get(), &info) != 0) return tl::unexpected<Error>(IoError("read", path, errno));
  const auto size = static_cast<uint64_t>(info.st_size);
  if (size > max_bytes) {
    return Fail(ErrorCode::kExhausted, "{} is {} bytes long, at most {} are read: it is not the right file",
                path.string(), size, max_bytes);
  }
  Buffer content(size, typename Buffer::value_type{});
  uint64_t done = 0;
  while (done < size) {
    const ssize_t count = ::read(file.get(), content.data() + done, size - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return tl::unexpected<Error>(IoError("read", path, errno));
    if (count == 0) break;  // it shrank meanwhile
    done += static_cast<uint64_t>(count);
  }
  content.resize(done);
  return content;
}

}  // namespace

Result<std::vector<std::byte>> ReadFile(const std::filesystem::path& path, uint64_t max_bytes, Links links) {
  return Read<std::vector<std::byte>>(path, max_bytes, links);
}

Result<std::string> ReadTextFile(const std::filesystem::path& path, uint64_t max_bytes, Links links) {
  return Read<std::string>(path, max_bytes, links);
}

}  // namespace dadrl
