#include "deploy/local/log_tail.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <sstream>

namespace dadrl {

std::vector<std::string> LogTail(const std::filesystem::path& file, size_t lines) {
  const auto open = FileDescriptor::Open(file, O_RDONLY);
  return open ? LogTail(*open, lines) : std::vector<std::string>();
}

std::vector<std::string> LogTail(const FileDescriptor& file, size_t lines) {
  constexpr off_t kMaxBytes = 16 << 10;
  std::string end(kMaxBytes, '\0');
  // Not lseek: a child may be writing at the descriptor's position.
  struct stat info {};
  if (fstat(file.get(), &info) != 0) return {};
  const ssize_t count =
      pread(file.get(), end.data(), end.size(), std::max<off_t>(0, info.st_size - kMaxBytes));
  if (count <= 0) return {};
  std::istringstream stream(end.substr(0, static_cast<size_t>(count)));
  std::vector<std::string> tail;
  for (std::string line; std::getline(stream, line);) tail.push_back(std::move(line));
  if (tail.size() > lines) tail.erase(tail.begin(), tail.end() - static_cast<std::ptrdiff_t>(lines));
  return tail;
}

}  // namespace dadrl
