// A fixed number of mutated inputs for every decoder, the same ones each time: the fuzzer's share of every
// build.
#include <gtest/gtest.h>

#include "common/util/random.h"
#include "tests/fuzz/decoders.h"

namespace dadrl {
namespace {

constexpr int kMutants = 300000;

// One to four small damages of the kinds that break decoders.
std::vector<uint8_t> Mutate(const std::vector<std::vector<uint8_t>>& seeds, Random& random) {
  std::vector<uint8_t> input = seeds[random.Below(seeds.size())];
  constexpr uint8_t kInteresting[] = {0, 1, 0x7f, 0x80, 0xff};
  for (uint64_t edits = 1 + random.Below(4); edits > 0 && input.size() > 1; --edits) {
    const size_t at = 1 + random.Below(input.size() - 1);
    const auto place = input.begin() + static_cast<ptrdiff_t>(at);
    switch (random.Below(6)) {
      case 0:
        input[at] ^= static_cast<uint8_t>(1u << random.Below(8));
        break;
      case 1:
        input[at] = kInteresting[random.Below(std::size(kInteresting))];
        break;
      case 2:
        input.resize(at);
        break;
      case 3:
        input.erase(place);
        break;
      case 4:
        input.insert(place, static_cast<uint8_t>(random.Next()));
        break;
      default: {
        const auto& other = seeds[random.Below(seeds.size())];
        const size_t length = std::min<size_t>(1 + random.Below(16), input.size() - at);
        const size_t from = random.Below(other.size());
        for (size_t i = 0; i < length; ++i) input[at + i] = other[(from + i) % other.size()];
      }
    }
  }
  return input;
}

TEST(DecoderMutation, NoInputBreaksADecoder) {
  const auto seeds = SeedInputs();
  ASSERT_FALSE(seeds.empty());
  for (const auto& seed : seeds) EXPECT_TRUE(CheckDecoder(seed)) << "decoder " << int{seed[0]};
  Random random(20240607);
  for (int i = 0; i < kMutants; ++i) CheckDecoder(Mutate(seeds, random));
}

TEST(DecoderMutation, PureNoiseBreaksNoDecoder) {
  Random random(1);
  for (int i = 0; i < kMutants / 4; ++i) {
    std::vector<uint8_t> input(random.Below(400));
    for (uint8_t& byte : input) byte = static_cast<uint8_t>(random.Next());
    CheckDecoder(input);
  }
}

}  // namespace
}  // namespace dadrl
