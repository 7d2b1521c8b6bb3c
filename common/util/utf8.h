// UTF-8 text from outside.
#pragma once

#include <cstddef>
#include <string_view>

namespace dadrl {

// Whether it is well-formed UTF-8 (RFC 3629) without control characters.
bool IsPrintableUtf8(std::string_view text);

// The longest part at the start that has at most `max_bytes` bytes and does not cut a character.
std::string_view Utf8Prefix(std::string_view text, size_t max_bytes);

}  // namespace dadrl
