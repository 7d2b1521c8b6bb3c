#include "deploy/local/build_info.h"

#include <gmock/gmock.h>

namespace dadrl {
namespace {

using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;

TEST(BuildInfo, NamesTheCommit) {
  EXPECT_THAT(BuildCommit(), MatchesRegex("unknown|[0-9a-f]{12,40}(-dirty)?"));
}

TEST(BuildInfo, NamesTheProcessorAndItsCores) {
  EXPECT_THAT(MachineName(), MatchesRegex(".+, [0-9]+ cores"));
#ifdef __x86_64__
  EXPECT_THAT(MachineName(), Not(HasSubstr("unknown")));
#endif
}

}  // namespace
}  // namespace dadrl
