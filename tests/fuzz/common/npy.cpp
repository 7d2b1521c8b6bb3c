// NumPy arrays: the shape is that of the numbers behind it.
#include "common/io/npy.h"

#include "tests/fuzz/outside_text.h"

namespace dadrl::fuzz {
namespace {

Bytes Array(std::string_view type, const std::vector<size_t>& shape, size_t value_bytes) {
  return AsBytes(NpyHeader(type, shape) + std::string(value_bytes, '\0'));
}

}  // namespace

const int kMutants = 100000;

bool Check(std::span<std::byte> input) {
  const auto array = ParseNpy(input, "<f4", "array.npy");
  if (!Accepted(array)) return false;
  size_t size = sizeof(float);
  for (const size_t length : array->shape) size *= length;
  Require(size == array->values.size() && array->values.size() < input.size());
  return true;
}

Seeds MakeSeeds() {
  const std::string fortran = "{'descr': '<f4', 'fortran_order': True, 'shape': (1,), }\n";
  return {.accepted = {Array("<f4", {2, 3}, 24), Array("<f4", {}, 4), Array("<f4", {0, 7}, 0)},
          .refused = {Array("<f4", {size_t{1} << 62, 4, 4}, 0), Array("|O", {1}, 8), Array("<f8", {1}, 8),
                      AsBytes(std::string("\x93NUMPY\x02\x00\xff\xff\xff\xff{", 13)),
                      AsBytes(std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(fortran.size()) + '\0' +
                              fortran + std::string(4, '\0')),
                      Array("<f4", std::vector<size_t>(33, 1), 4)}};
}

}  // namespace dadrl::fuzz
