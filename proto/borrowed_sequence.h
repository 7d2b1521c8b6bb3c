// Our memory as a sequence of a DDS message.
#pragma once

#include <cstddef>
#include <cstdint>
#include <ranges>
#include <type_traits>

namespace dadrl {

// `data` until the message is written: the middleware only reads while it serialises; its struct knows no
// const. Shorter than 2^32 elements, as every sequence of cluster.idl is.
template <std::ranges::contiguous_range Data, typename Sequence>
void Borrow(const Data& data, Sequence& sequence) {
  using Element = std::remove_pointer_t<decltype(sequence._buffer)>;
  using Ours = std::ranges::range_value_t<Data>;
  static_assert(sizeof(Element) == sizeof(Ours));
  const uint32_t length = std::ranges::size(data);
  auto* const first = const_cast<Ours*>(std::ranges::data(data));
  sequence = {length, length, reinterpret_cast<Element*>(first), false};
}

}  // namespace dadrl
