// Writes the seed inputs as files, where libFuzzer starts from: fuzz_seeds FOLDER.
#include <fmt/core.h>

#include <filesystem>
#include <fstream>

#include "tests/fuzz/decoders.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: fuzz_seeds FOLDER\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  int number = 0;
  for (const auto& seed : dadrl::SeedInputs()) {
    std::ofstream file(folder / std::to_string(number++), std::ios::binary);
    file.write(reinterpret_cast<const char*>(seed.data()), static_cast<std::streamsize>(seed.size()));
    if (!file.flush()) {
      fmt::print(stderr, "fuzz_seeds: cannot write into {}\n", folder.string());
      return 1;
    }
  }
  return 0;
}
