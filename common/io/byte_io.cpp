#include "common/io/byte_io.h"

namespace dadrl {

// Out of line: g++ 12 inlines the growth of small vectors and then warns of overflows that are not there.
void ByteWriter::PutBytes(std::span<const std::byte> bytes) {
  out_.insert(out_.end(), bytes.begin(), bytes.end());
}

}  // namespace dadrl
