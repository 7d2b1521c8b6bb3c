#include "proto/evaluation/seed_range.h"

#include <charconv>

namespace dadrl {
namespace {

constexpr int kMostSeeds = 1'000'000;

// The whole text is one number.
template <typename Number>
bool ParseWhole(std::string_view text, Number& number) {
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && stop == end;
}

}  // namespace

Result<SeedRange> ParseSeedRange(const std::string& text) {
  const size_t colon = text.find(':');
  SeedRange range;
  if (colon == std::string::npos || !ParseWhole(std::string_view(text).substr(0, colon), range.first) ||
      !ParseWhole(std::string_view(text).substr(colon + 1), range.count) || range.count < 1 ||
      range.count > kMostSeeds) {
    return Fail(ErrorCode::kInvalidArgument, "--seeds: '{}' is not FIRST:COUNT with a COUNT of 1 to {}", text,
                kMostSeeds);
  }
  if (range.first > UINT64_MAX - static_cast<uint64_t>(range.count)) {
    return Fail(ErrorCode::kInvalidArgument, "--seeds: '{}' goes beyond the largest seed, {}", text,
                UINT64_MAX);
  }
  return range;
}

std::string ToText(const SeedRange& range) { return fmt::format("{}:{}", range.first, range.count); }

}  // namespace dadrl
