#include "common/io/each_line.h"

#include <fcntl.h>

#include <span>
#include <string>

#include "common/io/file_descriptor.h"
#include "common/io/read_file.h"

namespace dadrl {

void ForEachLine(const std::filesystem::path& path, const std::function<void(std::string_view)>& visit) {
  const auto file = FileDescriptor::Open(path, O_RDONLY);
  if (!file) return;
  std::string text;  // a line's beginning, then what is read
  std::string block(size_t{64} << 10, '\0');
  for (;;) {
    const Result<size_t> read = ReadUpTo(*file, std::as_writable_bytes(std::span(block)), path);
    if (!read) return;
    if (*read == 0) break;
    text.append(block, 0, *read);
    std::string_view rest = text;
    for (size_t end = 0; (end = rest.find('\n')) != std::string_view::npos; rest.remove_prefix(end + 1)) {
      visit(rest.substr(0, end));
    }
    text.erase(0, text.size() - rest.size());
    if (text.size() > kLongestLine) return;
  }
  if (!text.empty()) visit(text);
}

}  // namespace dadrl
