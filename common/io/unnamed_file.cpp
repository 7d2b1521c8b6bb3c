#include "common/io/unnamed_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

namespace dadrl {
namespace {

// Made and removed at once; invalid where the folder is not there or takes no files.
FileDescriptor OpenRemoved(const std::filesystem::path& folder) {
  std::string path = (folder / "dadrl-XXXXXX").string();
  FileDescriptor file(mkostemp(path.data(), O_CLOEXEC));
  if (file.valid()) unlink(path.c_str());
  return file;
}

}  // namespace

Result<FileDescriptor> OpenUnnamedFile(const char* name) {
  FileDescriptor file(memfd_create(name, MFD_CLOEXEC));
  if (file.valid()) return file;
  const int error = errno;
  std::error_code no_temporary_folder;
  for (const std::filesystem::path& folder :
       {std::filesystem::path("/dev/shm"), std::filesystem::temp_directory_path(no_temporary_folder)}) {
    if (folder.empty()) continue;
    file = OpenRemoved(folder);
    if (file.valid()) return file;
  }
  return Fail(ErrorCode::kExhausted,
              "no file in memory: memfd_create: {}, and neither /dev/shm nor TMPDIR takes one",
              std::strerror(error));
}

std::filesystem::path UnnamedFilePath(const FileDescriptor& file) {
  return fmt::format("/proc/self/fd/{}", file.get());
}

}  // namespace dadrl
