#include "deploy/monitor/text_columns.h"

#include <algorithm>

namespace dadrl {
namespace {

bool IsContinuation(char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; }

bool IsControl(std::string_view character) {
  const auto first = static_cast<unsigned char>(character[0]);
  const bool c1 = first == 0xC2 && character.size() > 1 && static_cast<unsigned char>(character[1]) < 0xA0;
  return first < 0x20 || first == 0x7F || c1;
}

}  // namespace

size_t CountColumns(std::string_view text) {
  return text.size() - static_cast<size_t>(std::count_if(text.begin(), text.end(), IsContinuation));
}

std::string ClipColumns(std::string_view text, size_t columns) {
  std::string clipped;
  for (size_t column = 0; column < columns && !text.empty(); ++column) {
    size_t bytes = 1;
    while (bytes < text.size() && IsContinuation(text[bytes])) ++bytes;
    const std::string_view character = text.substr(0, bytes);
    clipped += IsControl(character) ? "?" : character;
    text.remove_prefix(bytes);
  }
  return clipped;
}

std::string ShortenColumns(std::string_view text, size_t columns) {
  constexpr std::string_view kMore = "...";
  if (CountColumns(text) <= columns || columns <= kMore.size()) return ClipColumns(text, columns);
  return ClipColumns(text, columns - kMore.size()).append(kMore);
}

}  // namespace dadrl
