#include "common/util/utf8.h"

#include <array>
#include <cstdint>

namespace dadrl {
namespace {

struct Form {
  uint8_t mask;  // of the first byte
  uint8_t lead;  // what it is then
  size_t length;
  uint32_t least;  // smaller code points have a shorter form
};
constexpr std::array<Form, 4> kForms = {
    {{0x80, 0x00, 1, 0}, {0xE0, 0xC0, 2, 0x80}, {0xF0, 0xE0, 3, 0x800}, {0xF8, 0xF0, 4, 0x10000}}};

bool IsContinuation(char c) { return (static_cast<uint8_t>(c) & 0xC0) == 0x80; }

// Bytes of the printable character at the start of `text`; 0: there is none.
size_t PrintableAt(std::string_view text) {
  const auto first = static_cast<uint8_t>(text[0]);
  for (const Form& form : kForms) {
    if ((first & form.mask) != form.lead) continue;
    if (text.size() < form.length) return 0;
    uint32_t code = first & static_cast<uint8_t>(~form.mask);
    for (const char c : text.substr(1, form.length - 1)) {
      if (!IsContinuation(c)) return 0;
      code = code << 6 | (static_cast<uint8_t>(c) & 0x3Fu);
    }
    const bool control = code < 0x20 || (code >= 0x7F && code < 0xA0);
    const bool surrogate = code >= 0xD800 && code < 0xE000;
    return control || surrogate || code < form.least || code > 0x10FFFF ? 0 : form.length;
  }
  return 0;
}

}  // namespace

bool IsPrintableUtf8(std::string_view text) {
  while (!text.empty()) {
    const size_t length = PrintableAt(text);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

std::string_view Utf8Prefix(std::string_view text, size_t max_bytes) {
  if (text.size() <= max_bytes) return text;
  while (max_bytes > 0 && IsContinuation(text[max_bytes])) --max_bytes;
  return text.substr(0, max_bytes);
}

}  // namespace dadrl
