#include "common/io/mapped_file.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <cerrno>
#include <utility>

#include "common/io/io_error.h"

namespace dadrl {

Result<MappedFile> MappedFile::Open(const std::filesystem::path& path, Links links) {
  DADRL_ASSIGN_OR_RETURN(const FileDescriptor file, FileDescriptor::Open(path, O_RDONLY, links));
  struct stat status {};
  if (fstat(file.get(), &status) != 0) return tl::unexpected(IoError("stat", path, errno));
  const auto size = static_cast<uint64_t>(status.st_size);
  if (size == 0) return MappedFile(GuardedMapping());
  DADRL_ASSIGN_OR_RETURN(GuardedMapping mapping, GuardedMapping::Map(file, size, path));
  return MappedFile(std::move(mapping));
}

}  // namespace dadrl
