// libFuzzer's entry; DADRL_FUZZ=ON builds it. Seeds: fuzz_seeds FOLDER.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/decoders.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  dadrl::CheckDecoder({data, size});
  return 0;
}
