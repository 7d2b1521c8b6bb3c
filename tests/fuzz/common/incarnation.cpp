// What a file of incarnations says: each start still counts as newer than the one before.
#include "common/io/incarnation.h"

#include "tests/fuzz/outside_text.h"

namespace dadrl::fuzz {

const int kMutants = 3000;

bool Check(std::span<std::byte> input) {
  Written("incarnations/replay", input);
  constexpr int64_t kNow = 1'700'000'000'000'000'000;
  constexpr uint64_t kYear2258 = 9'100'000'000'000'000'000;  // beyond it no file is believed
  const uint64_t first = NextIncarnation(Folder(), "replay", kNow);
  Require(first >= static_cast<uint64_t>(kNow));
  Require(first > kYear2258 || NextIncarnation(Folder(), "replay", kNow) > first);
  return first > static_cast<uint64_t>(kNow);
}

Seeds MakeSeeds() {
  return {.accepted = {AsBytes("1800000000000000000\n")},
          .refused = {AsBytes("18446744073709551615\n"), AsBytes("99999999999999999999999\n"),
                      AsBytes("-1\n"), AsBytes("no number"), AsBytes(Repeated("9", 100))}};
}

}  // namespace dadrl::fuzz
