#include "proto/named_scalar.h"

#include <fmt/format.h>

#include <algorithm>

namespace dadrl {

bool IsScalarName(std::string_view name) {
  return !name.empty() && name.size() <= kMaxScalarName && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

std::string ScalarsText(std::span<const NamedScalar> scalars) {
  std::string text;
  for (const NamedScalar& scalar : scalars) {
    std::string words = scalar.name;
    std::ranges::replace(words, '_', ' ');
    text += fmt::format("{}{} {:.3g}", text.empty() ? "" : ", ", words, scalar.value);
  }
  return text;
}

}  // namespace dadrl
