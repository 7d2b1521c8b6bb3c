// The same of lines about drawn episodes.
#include "proto/evaluation/rendered_episode.h"
#include "tests/fuzz/outside_text.h"

namespace dadrl::fuzz {

const int kMutants = 30000;

bool Check(std::span<std::byte> input) {
  const auto episode = ParseRenderedLine(AsText(input));
  if (!Accepted(episode)) return false;
  Require(ParseRenderedLine(RenderedLine(*episode)).value() == *episode);
  return true;
}

Seeds MakeSeeds() {
  const RenderedEpisode episode{
      .seed = 3, .outcome = Outcome::kSuccess, .steps = 10, .sentence = "arrived", .files = {"a.svg"}};
  return {.accepted = {AsBytes(RenderedLine(episode)), AsBytes(RenderedLine({}))}, .refused = BadJson()};
}

}  // namespace dadrl::fuzz
