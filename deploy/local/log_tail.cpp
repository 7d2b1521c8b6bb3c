#include "deploy/local/log_tail.h"

#include <algorithm>
#include <fstream>

namespace dadrl {

std::vector<std::string> LogTail(const std::filesystem::path& file, size_t lines) {
  constexpr std::streamoff kMaxBytes = 16 << 10;
  std::ifstream stream(file, std::ios::binary | std::ios::ate);
  if (!stream) return {};
  const std::streamoff size = stream.tellg();
  stream.seekg(std::max<std::streamoff>(0, size - kMaxBytes));
  std::vector<std::string> tail;
  for (std::string line; std::getline(stream, line);) tail.push_back(std::move(line));
  if (tail.size() > lines) tail.erase(tail.begin(), tail.end() - static_cast<std::ptrdiff_t>(lines));
  return tail;
}

}  // namespace dadrl
