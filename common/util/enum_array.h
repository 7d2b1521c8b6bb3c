// An array with an element for each value of an enumeration, which are 0, 1, 2, ...
#pragma once

#include <array>
#include <cstddef>

namespace dadrl {

// `kSize`: how many values there are; a last one named kCount says it itself.
template <typename Enum, typename T, size_t kSize = static_cast<size_t>(Enum::kCount)>
struct EnumArray : std::array<T, kSize> {
  using std::array<T, kSize>::operator[];
  constexpr T& operator[](Enum value) { return (*this)[static_cast<size_t>(value)]; }
  constexpr const T& operator[](Enum value) const { return (*this)[static_cast<size_t>(value)]; }
  // The value whose element is at `index`.
  static constexpr Enum At(size_t index) { return static_cast<Enum>(index); }
};

}  // namespace dadrl
