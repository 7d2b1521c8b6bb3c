#include "common/util/shown.h"

#include <fmt/format.h>

namespace dadrl {

std::string Shown(std::string_view text, size_t most) {
  std::string shown;
  for (const char c : text.substr(0, most)) {
    const auto byte = static_cast<unsigned char>(c);
    shown += byte < 0x20 || byte == 0x7f ? fmt::format("\\x{:02x}", byte) : std::string(1, c);
  }
  return text.size() > most ? shown + "..." : shown;
}

}  // namespace dadrl
