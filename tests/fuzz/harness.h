// What fuzz targets share.
#pragma once

#include <cstdint>
#include <span>

#include "tests/fuzz/target.h"

namespace dadrl::fuzz {

// Aborts: the decoder under test broke its contract.
void Require(bool condition);

// Check on a copy that ends where an unreadable page begins.
bool CheckGuarded(std::span<const std::byte> input);

// Writes the xxh3-64 of all but the last eight bytes into these, so that mutations get past a checksum.
void MendChecksum(std::span<std::byte> bytes);

// A flag in front of the input: mended where it is odd, so that checksums are tested as well. Returns the
// rest.
std::span<std::byte> MendedIfAsked(std::span<std::byte> input);
// An input for MendedIfAsked.
Bytes AskMended(std::span<const std::byte> bytes);

}  // namespace dadrl::fuzz
