#include "proto/evaluation/seed_range.h"

#include <gtest/gtest.h>

namespace dadrl {
namespace {

TEST(SeedRange, IsReadAsItIsWritten) {
  const SeedRange range{18'446'744'073'709'551'000U, 50};
  const auto parsed = ParseSeedRange(ToText(range));
  ASSERT_TRUE(parsed) << parsed.error().message;
  EXPECT_EQ(*parsed, range);
}

TEST(SeedRange, AnythingElseIsRefused) {
  for (const char* text : {"", "5", "5:", ":5", "5:0", "5:-1", "-5:1", "5:1000001", "5:5x", " 5:5", "5:5:5",
                           "18446744073709551615:2"}) {
    const auto parsed = ParseSeedRange(text);
    ASSERT_FALSE(parsed) << text;
    EXPECT_EQ(parsed.error().code, ErrorCode::kInvalidArgument);
  }
}

}  // namespace
}  // namespace dadrl
