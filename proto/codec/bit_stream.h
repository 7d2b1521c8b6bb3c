// Bits to and from bytes, least significant first. The reader is safe on hostile input by construction: past
// the end it yields zeros and remembers that it did.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "common/io/byte_io.h"

namespace dadrl {

// Not thread safe. Writes into borrowed memory, which the caller sizes for the worst case.
class BitWriter {
 public:
  explicit BitWriter(std::span<std::byte> out) : out_(out) {}

  // `bits` of 0 to 32; `value` has no bit above them.
  void Put(uint64_t value, int bits) {
    assert(bits >= 0 && bits <= 32 && (bits == 32 || value >> bits == 0));
    buffer_ |= value << filled_;
    filled_ += bits;
    if (filled_ >= 32) {
      assert(position_ + 4 <= out_.size());
      const auto word = static_cast<uint32_t>(buffer_);
      std::memcpy(out_.data() + position_, &word, 4);
      position_ += 4;
      buffer_ >>= 32;
      filled_ -= 32;
    }
  }

  // Pads with zeros to a whole byte; the bytes written. Call once, last.
  size_t Finish() {
    for (; filled_ > 0; filled_ -= 8, buffer_ >>= 8) {
      assert(position_ < out_.size());
      out_[position_++] = static_cast<std::byte>(buffer_ & 0xff);
    }
    filled_ = 0;
    return position_;
  }

 private:
  std::span<std::byte> out_;
  size_t position_ = 0;
  uint64_t buffer_ = 0;
  int filled_ = 0;
};

// Not thread safe. Borrows its input and never reads outside it.
class BitReader {
 public:
  explicit BitReader(std::span<const std::byte> in) : in_(in) {}

  // The next `bits` (0 to 32).
  uint32_t Get(int bits) {
    const uint32_t value = Peek(bits);
    Skip(bits);
    return value;
  }
  uint32_t Peek(int bits) {
    if (filled_ < bits) Refill();
    return static_cast<uint32_t>(buffer_ & ((uint64_t{1} << bits) - 1));
  }
  // Drops bits that a Peek has shown.
  void Skip(int bits) {
    buffer_ >>= bits;
    filled_ -= bits;
  }

  // True when what was read is the whole input: nothing past its end, and nothing but zero padding to the
  // byte left.
  bool AtExactEnd() const {
    const size_t consumed_bits = 8 * position_ + invented_bits_ - static_cast<size_t>(filled_);
    const size_t total_bits = 8 * in_.size();
    return consumed_bits <= total_bits && total_bits - consumed_bits < 8 && buffer_ == 0;
  }

 private:
  // Called with fewer than 32 bits left; leaves at least 32.
  void Refill() {
    if (in_.size() - position_ >= 4) {
      uint32_t word = 0;
      std::memcpy(&word, in_.data() + position_, 4);
      buffer_ |= uint64_t{word} << filled_;
      position_ += 4;
      filled_ += 32;
      return;
    }
    for (; position_ < in_.size(); filled_ += 8) {
      buffer_ |= static_cast<uint64_t>(in_[position_++]) << filled_;
    }
    if (filled_ < 32) {
      invented_bits_ += 32;
      filled_ += 32;
    }
  }

  std::span<const std::byte> in_;
  size_t position_ = 0;
  uint64_t buffer_ = 0;
  int filled_ = 0;
  size_t invented_bits_ = 0;
};

}  // namespace dadrl
