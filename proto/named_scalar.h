// Numbers of a learning algorithm under the names that it declares: nobody between it and the user knows
// which ones there are.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace dadrl {

// What a status message has room for.
constexpr int kMaxScalars = 16;
constexpr size_t kMaxScalarName = 23;

struct NamedScalar {
  std::string name;
  double value = 0.0;

  bool operator==(const NamedScalar&) const = default;
};

// Whether it is one to kMaxScalarName small letters, digits and underscores.
bool IsScalarName(std::string_view name);

// "critic loss 0.0123, temperature 0.05"; empty without any.
std::string ScalarsText(std::span<const NamedScalar> scalars);

}  // namespace dadrl
