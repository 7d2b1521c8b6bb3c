#include "actor/sim/memory_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "common/io/unnamed_file.h"

namespace dadrl {

Result<MemoryFile> MemoryFile::Create(const char* name) {
  DADRL_ASSIGN_OR_RETURN(FileDescriptor file, OpenUnnamedFile(name));
  return MemoryFile(std::move(file));
}

std::string MemoryFile::path() const { return UnnamedFilePath(file_); }

Status MemoryFile::Write(std::string_view text) {
  bool written = ftruncate(file_.get(), 0) == 0;
  for (size_t done = 0; written && done < text.size();) {
    const ssize_t count =
        pwrite(file_.get(), text.data() + done, text.size() - done, static_cast<off_t>(done));
    if (count > 0) done += static_cast<size_t>(count);
    written = count > 0 || errno == EINTR;
  }
  if (written) return {};
  return Fail(ErrorCode::kExhausted, "cannot write a file in memory: {}", std::strerror(errno));
}

std::string MemoryFile::Read() const {
  std::string text(static_cast<size_t>(lseek(file_.get(), 0, SEEK_END)), '\0');
  const ssize_t count = pread(file_.get(), text.data(), text.size(), 0);
  text.resize(count > 0 ? static_cast<size_t>(count) : 0);
  return text;
}

}  // namespace dadrl
