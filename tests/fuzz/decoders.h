// One harness over every decoder of experience, for libFuzzer and for the fixed-count mutation test.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace dadrl {

// The first byte chooses the decoder, the rest is its input; with the high bit set the input's checksum is
// mended first, so that mutations get past it. Aborts when a decoder breaks its contract: reads outside its
// input (under a sanitizer, or into a guard page), accepts what it cannot have written, or accepts floats
// that are not finite. True when the decoder accepted the input.
bool CheckDecoder(std::span<const uint8_t> input);

// Valid inputs for all decoders.
std::vector<std::vector<uint8_t>> SeedInputs();

}  // namespace dadrl
