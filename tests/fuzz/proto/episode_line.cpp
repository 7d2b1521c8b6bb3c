// Lines between processes: an episode that is taken is printed as it was read.
#include "proto/evaluation/episode_line.h"

#include <cmath>

#include "tests/fuzz/outside_text.h"

namespace dadrl::fuzz {

const int kMutants = 30000;

bool Check(std::span<std::byte> input) {
  const auto episode = ParseEpisodeLine(AsText(input));
  if (!Accepted(episode)) return false;
  Require(std::isfinite(episode->summary.episode_return) && episode->summary.steps >= 0);
  Require(ParseEpisodeLine(EpisodeLine(*episode)).value() == *episode);
  return true;
}

Seeds MakeSeeds() {
  EvaluatedEpisode episode;
  episode.summary.scenario = "left_turn";
  episode.summary.seed = kFirstEvaluationSeed;
  episode.summary.outcome = Outcome::kCollision;
  episode.summary.collision = CollisionSummary{};
  Seeds seeds{.accepted = {AsBytes(EpisodeLine(episode)),
                           AsBytes(R"({"group":0,"seed":1,"scenario":"s","error":"lost"})")},
              .refused = BadJson()};
  seeds.refused.push_back(
      AsBytes(R"({"group":0,"seed":1,"scenario":"s","outcome":"success","steps":1e300})"));
  seeds.refused.push_back(
      AsBytes(R"({"group":0,"seed":1,"scenario":")" + std::string(100000, 's') + R"("})"));
  return seeds;
}

}  // namespace dadrl::fuzz
