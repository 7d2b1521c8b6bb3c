// The fuzzer's share of every build: the seeds, and a fixed number of damaged ones, the same each time.
#include <gtest/gtest.h>

#include <iterator>

#include "common/util/random.h"
#include "tests/fuzz/harness.h"

namespace dadrl::fuzz {
namespace {

// One small damage of the kinds that break decoders.
void Damage(Bytes& input, const std::vector<Bytes>& seeds, Random& random) {
  constexpr uint8_t kInteresting[] = {0, 1, 0x7f, 0x80, 0xff};
  const auto byte = [](uint64_t value) { return static_cast<std::byte>(value & 0xff); };
  const size_t at = random.Below(input.size());
  const auto place = input.begin() + static_cast<ptrdiff_t>(at);
  switch (random.Below(7)) {
    case 0:
      input[at] ^= byte(uint64_t{1} << random.Below(8));
      break;
    case 1:
      input[at] = byte(kInteresting[random.Below(std::size(kInteresting))]);
      break;
    case 2:
      input.resize(at);
      break;
    case 3:
      input.erase(place);
      break;
    case 4:
      input.insert(place, byte(random.Next()));
      break;
    case 5:  // a whole number at its largest
      for (size_t i = at; i < std::min(at + 8, input.size()); ++i) input[i] = std::byte{0xff};
      break;
    default: {  // a piece of another input
      const Bytes& other = seeds[random.Below(seeds.size())];
      const size_t length = std::min<size_t>(1 + random.Below(16), input.size() - at);
      const size_t from = random.Below(other.size());
      for (size_t i = 0; i < length; ++i) input[at + i] = other[(from + i) % other.size()];
    }
  }
}

TEST(Mutation, SeedsAreTakenOrRefusedAsTheySay) {
  const Seeds seeds = MakeSeeds();
  ASSERT_FALSE(seeds.accepted.empty());
  for (size_t i = 0; i < seeds.accepted.size(); ++i) EXPECT_TRUE(CheckGuarded(seeds.accepted[i])) << i;
  for (size_t i = 0; i < seeds.refused.size(); ++i) EXPECT_FALSE(CheckGuarded(seeds.refused[i])) << i;
}

TEST(Mutation, NoDamageBreaksTheDecoder) {
  Seeds seeds = MakeSeeds();
  std::vector<Bytes> all = std::move(seeds.accepted);
  all.insert(all.end(), seeds.refused.begin(), seeds.refused.end());
  std::erase_if(all, [](const Bytes& input) { return input.empty(); });  // nothing to damage
  Random random(20240607);
  for (int i = 0; i < kMutants; ++i) {
    Bytes input = all[random.Below(all.size())];
    for (uint64_t edits = 1 + random.Below(4); edits > 0 && !input.empty(); --edits) {
      Damage(input, all, random);
    }
    CheckGuarded(input);
  }
}

TEST(Mutation, NoNoiseBreaksTheDecoder) {
  Random random(1);
  for (int i = 0; i < kMutants / 4; ++i) {
    Bytes input(random.Below(400));
    for (std::byte& byte : input) byte = static_cast<std::byte>(random.Next() & 0xff);
    CheckGuarded(input);
  }
}

}  // namespace
}  // namespace dadrl::fuzz
