// What a user writes behind `dadrl actor --join`.
#include <string>

#include "deploy/local/run_finder.h"
#include "tests/fuzz/harness.h"

namespace dadrl::fuzz {
namespace {

Bytes Input(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

}  // namespace

const int kMutants = 200000;

bool Check(std::span<std::byte> input) {
  const std::string text(reinterpret_cast<const char*>(input.data()), input.size());
  const auto place = ParseRunPlace(text);
  if (!place) return false;
  Require(!place->host.empty() && place->host.size() <= text.size());
  Require(place->port >= 0 && place->port <= 60000);
  const auto again =
      ParseRunPlace(place->port == 0 ? place->host : fmt::format("{}:{}", place->host, place->port));
  Require(again && again->host == place->host && again->port == place->port);
  return true;
}

Seeds MakeSeeds() {
  Seeds seeds;
  for (const char* text : {"10.0.0.1", "10.0.0.1:12000", "node7", "node7:60000"}) {
    seeds.accepted.push_back(Input(text));
  }
  for (const char* text : {"", ":1", "node7:", "node7:0", "node7:60001", "node7:1x", "node7:-1"}) {
    seeds.refused.push_back(Input(text));
  }
  return seeds;
}

}  // namespace dadrl::fuzz
