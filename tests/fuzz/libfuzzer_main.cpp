// libFuzzer's entry. The first folder of the command line gets the seeds when it is empty, and is where
// libFuzzer keeps what it finds.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>

#include "tests/fuzz/harness.h"

namespace {

void WriteSeeds(const std::filesystem::path& folder) {
  const dadrl::fuzz::Seeds seeds = dadrl::fuzz::MakeSeeds();
  int number = 0;
  for (const auto* inputs : {&seeds.accepted, &seeds.refused}) {
    for (const dadrl::fuzz::Bytes& input : *inputs) {
      std::ofstream file(folder / ("seed-" + std::to_string(number++)), std::ios::binary);
      file.write(reinterpret_cast<const char*>(input.data()), static_cast<std::streamsize>(input.size()));
      dadrl::fuzz::Require(static_cast<bool>(file.flush()));
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  const std::span<char*> words(*argv, static_cast<size_t>(*argc));
  const auto folder = std::find_if(words.begin() + 1, words.end(), [](const char* word) {
    std::error_code error;
    return word[0] != '-' && std::filesystem::is_directory(word, error);
  });
  if (folder != words.end() && std::filesystem::is_empty(*folder)) WriteSeeds(*folder);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  dadrl::fuzz::CheckGuarded(std::as_bytes(std::span(data, size)));
  return 0;
}
