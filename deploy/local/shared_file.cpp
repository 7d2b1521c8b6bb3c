#include "deploy/local/shared_file.h"

#include <unistd.h>

#include "common/io/unnamed_file.h"

namespace dadrl {

Result<SharedFile> SharedFile::Create(const char* name, std::span<const std::byte> content) {
  DADRL_ASSIGN_OR_RETURN(FileDescriptor file, OpenUnnamedFile(name));
  DADRL_RETURN_IF_ERROR(WriteAll(file, content, name));
  return SharedFile(std::move(file));
}

std::filesystem::path SharedFile::path() const {
  return fmt::format("/proc/{}/fd/{}", getpid(), file_.get());
}

}  // namespace dadrl
