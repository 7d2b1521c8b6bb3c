// CRC-32C (Castagnoli, RFC 3720), the checksum of TensorBoard's record files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace dadrl {

uint32_t Crc32c(std::span<const std::byte> bytes);

// Rotated and offset, as TFRecord stores it (a checksum over data that holds checksums is weak otherwise).
uint32_t MaskedCrc32c(std::span<const std::byte> bytes);

}  // namespace dadrl
