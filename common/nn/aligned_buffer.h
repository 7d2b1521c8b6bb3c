// Memory for parameters and activations: aligned for vectors, backed by huge pages, owned in one place.
#pragma once

#include <concepts>
#include <cstddef>
#include <memory>
#include <span>
#include <type_traits>

namespace dadrl::nn {

constexpr size_t kAlignment = 64;                              // bytes: one cache line, one AVX-512 vector
constexpr size_t kAlignedFloats = kAlignment / sizeof(float);  // parameters are padded to multiples of this
template <std::integral N>
constexpr N RoundUp(N n, std::type_identity_t<N> multiple) {
  return (n + multiple - 1) / multiple * multiple;
}

// A fixed number of zeroed floats, 64-byte aligned; large ones ask for huge pages. Movable; moving keeps the
// address.
class FloatBuffer {
 public:
  FloatBuffer() = default;
  explicit FloatBuffer(size_t count);

  float* data() { return data_.get(); }
  const float* data() const { return data_.get(); }
  size_t size() const { return size_; }
  std::span<float> span() { return {data(), size_}; }
  std::span<const float> span() const { return {data(), size_}; }
  std::span<std::byte> bytes() { return std::as_writable_bytes(span()); }

 private:
  struct Release {
    void operator()(float* memory) const;
  };
  std::unique_ptr<float[], Release> data_;
  size_t size_ = 0;
};

// Hands out 64-byte aligned arrays of one block of memory. Default-constructed it only measures: lay the
// arrays out once on a measuring arena (the pointers are null), then again on `Arena(measured.used())`. Never
// frees singly, never grows: an Allocate beyond the capacity is a programmer's mistake and aborts. Not thread
// safe.
class Arena {
 public:
  Arena() = default;
  explicit Arena(size_t capacity) : buffer_(capacity), capacity_(capacity) {}

  // `count` floats, zeroed at first; not negative.
  float* Allocate(std::integral auto count) { return Take(static_cast<size_t>(count)); }
  // Floats handed out so far, padding included.
  size_t used() const { return used_; }

 private:
  float* Take(size_t count);

  FloatBuffer buffer_;
  size_t capacity_ = 0;
  size_t used_ = 0;
};

}  // namespace dadrl::nn
