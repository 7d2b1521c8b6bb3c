#include "proto/evaluation/rendered_episode.h"

#include <gtest/gtest.h>

namespace dadrl {
namespace {

TEST(RenderedEpisode, SurvivesItsLine) {
  const RenderedEpisode episode{.seed = 1'000'007,
                                .outcome = Outcome::kCollision,
                                .steps = 73,
                                .episode_return = -0.1 / 3,
                                .sentence = "collision with car 12 at 7.3 s",
                                .files = {"a \"b\"/1.png", "2.png"},
                                .error = ""};
  const std::string line = RenderedLine(episode);
  EXPECT_EQ(line.find('\n'), std::string::npos);
  const auto parsed = ParseRenderedLine(line);
  ASSERT_TRUE(parsed) << parsed.error().message;
  EXPECT_EQ(*parsed, episode);
}

TEST(RenderedEpisode, OtherLinesAreRefused) {
  std::string unknown = RenderedLine({});
  unknown.replace(unknown.find("stagnation"), 10, "flying");
  for (const std::string& line : {std::string(), std::string("{}"), std::string("not json"), unknown}) {
    const auto parsed = ParseRenderedLine(line);
    ASSERT_FALSE(parsed) << line;
    EXPECT_EQ(parsed.error().code, ErrorCode::kCorrupt);
  }
}

}  // namespace
}  // namespace dadrl
