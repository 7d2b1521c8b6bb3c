#include "actor/sim/memory_file.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace dadrl {

Result<MemoryFile> MemoryFile::Create(const char* name) {
  const int descriptor = memfd_create(name, MFD_CLOEXEC);
  if (descriptor < 0) {
    return Fail(ErrorCode::kExhausted, "cannot create a file in memory: {}", std::strerror(errno));
  }
  return MemoryFile(descriptor);
}

MemoryFile::~MemoryFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

std::string MemoryFile::path() const { return fmt::format("/proc/self/fd/{}", descriptor_); }

Status MemoryFile::Write(std::string_view text) {
  bool written = ftruncate(descriptor_, 0) == 0;
  for (size_t done = 0; written && done < text.size();) {
    const ssize_t count =
        pwrite(descriptor_, text.data() + done, text.size() - done, static_cast<off_t>(done));
    if (count > 0) done += static_cast<size_t>(count);
    written = count > 0 || errno == EINTR;
  }
  if (written) return {};
  return Fail(ErrorCode::kExhausted, "cannot write a file in memory: {}", std::strerror(errno));
}

std::string MemoryFile::Read() const {
  std::string text(static_cast<size_t>(lseek(descriptor_, 0, SEEK_END)), '\0');
  const ssize_t count = pread(descriptor_, text.data(), text.size(), 0);
  text.resize(count > 0 ? static_cast<size_t>(count) : 0);
  return text;
}

}  // namespace dadrl
