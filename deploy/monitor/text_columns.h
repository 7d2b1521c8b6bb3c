// Text in the columns of a terminal.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <string_view>

namespace dadrl {

struct TerminalSize {
  static constexpr size_t kUnbounded = std::numeric_limits<size_t>::max();

  size_t rows = kUnbounded;
  size_t columns = kUnbounded;
};

// Columns of UTF-8 text, one a character.
size_t CountColumns(std::string_view text);

// `text` on at most `columns` columns. Control characters become '?': a name from outside cannot move the
// cursor.
std::string ClipColumns(std::string_view text, size_t columns);

// The same; what had to be cut ends in "...".
std::string ShortenColumns(std::string_view text, size_t columns);

}  // namespace dadrl
