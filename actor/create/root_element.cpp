#include "actor/create/root_element.h"

#include <array>
#include <cctype>
#include <fstream>
#include <string_view>
#include <system_error>

namespace dadrl {
namespace {

constexpr size_t kLookAt = size_t{64} << 10;

// Comments, declarations and processing instructions stand before it.
std::string FirstElement(std::string_view text) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  while (!text.empty()) {
    const size_t begin = text.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos || text[begin] != '<' || begin + 1 >= text.size()) return {};
    text.remove_prefix(begin);
    if (text[1] != '?' && text[1] != '!') {
      const size_t end = text.find_first_of(" \t\r\n/>", 1);
      return std::string(text.substr(1, end == std::string_view::npos ? end : end - 1));
    }
    const std::string_view closing = text.starts_with("<!--") ? "-->" : ">";
    const size_t end = text.find(closing);
    if (end == std::string_view::npos) return {};
    text.remove_prefix(end + closing.size());
  }
  return {};
}

}  // namespace

Result<std::string> RootElement(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) {
    return Fail(ErrorCode::kInvalidArgument, "{} is a folder; name the file", file.string());
  }
  std::ifstream stream(file, std::ios::binary);
  if (!stream || !std::filesystem::is_regular_file(file, error)) {
    return Fail(ErrorCode::kNotFound, "there is no file {}", file.string());
  }
  std::string text(kLookAt, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<size_t>(stream.gcount()));
  if (text.starts_with("\x1f\x8b")) return std::string("?");
  return FirstElement(text);
}

}  // namespace dadrl
