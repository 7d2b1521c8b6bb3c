// What a user's command makes of the rate limiter. Input: the command's numbers.
#include "replay/service/limit_command.h"

#include "common/io/byte_io.h"
#include "tests/fuzz/harness.h"

namespace dadrl::fuzz {
namespace {

Bytes Input(int64_t min_size, double most, double least, double band) {
  Bytes bytes;
  ByteWriter writer(bytes);
  writer.Put(min_size);
  for (const double number : {most, least, band}) writer.Put(number);
  return bytes;
}

}  // namespace

const int kMutants = 200000;

bool Check(std::span<std::byte> input) {
  ByteReader reader(input);
  dadrl_idl_ReplayCommand command{};
  command.min_size = reader.Get<int64_t>();
  command.samples_per_insert = reader.Get<double>();
  command.min_samples_per_insert = reader.Get<double>();
  command.band_frames = reader.Get<double>();
  const auto changed = ChangedLimits({}, command);
  if (!changed) return false;
  Require(RateLimiter::IsPossible(*changed));
  RateLimiter limiter(*changed);
  limiter.OnInsert(INT32_MAX);
  Require(RateLimiter::IsPossible(limiter.state()));
  // Never both.
  Require(limiter.MayInsert(INT32_MAX) || limiter.MaySample(1, INT32_MAX) == RateLimiter::Hold::kNone ||
          changed->min_size > INT32_MAX);
  return true;
}

Seeds MakeSeeds() {
  return {
      .accepted = {Input(0, -1.0, -1.0, 0.0), Input(2000, 8.0, 1.0, 1000.0)},
      .refused = {Input(INT64_MAX, -1.0, -1.0, 0.0), Input(1, 1e300, -1.0, 0.0), Input(1, 1.0, 2.0, 0.0)}};
}

}  // namespace dadrl::fuzz
