// What one fuzz target is: two functions, defined once in each executable.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace dadrl::fuzz {

using Bytes = std::vector<std::byte>;

// Feeds `input` to the decoder; true when it was accepted. Aborts (Require, harness.h) when the decoder
// breaks its contract: accepts what it cannot have written, or what is not what it says. Reads outside the
// input end in an unreadable page, sanitizer or not. The same input has the same effect each time.
bool Check(std::span<std::byte> input);

// Valid inputs, every one of which Check accepts, and refused ones that once did harm.
struct Seeds {
  std::vector<Bytes> accepted;
  std::vector<Bytes> refused;
};
Seeds MakeSeeds();

// Mutants that the test of every build tries; libFuzzer goes on for as long as it is let.
extern const int kMutants;

}  // namespace dadrl::fuzz
