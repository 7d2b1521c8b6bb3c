// Asks for memory before it is read, so that many cache misses overlap.
#pragma once

#include <cstddef>

namespace dadrl {

// Only a hint: any address will do.
inline void Prefetch(const void* begin, size_t bytes) {
  constexpr size_t kCacheLine = 64;
  const auto* at = static_cast<const char*>(begin);
  for (size_t offset = 0; offset < bytes; offset += kCacheLine) __builtin_prefetch(at + offset);
}

}  // namespace dadrl
