// What `dadrl-actor render` reports for each episode: a line of JSON on its standard output.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/util/result.h"
#include "proto/evaluation/episode_summary.h"

namespace dadrl {

struct RenderedEpisode {
  uint64_t seed = 0;
  Outcome outcome = Outcome::kStagnation;
  int steps = 0;
  double episode_return = 0.0;
  std::string sentence;            // how it ended, for a reader
  std::vector<std::string> files;  // none when another outcome was asked for
  std::string error;               // why the simulator lost it; empty when it did not

  bool operator==(const RenderedEpisode&) const = default;
};

// One JSON object without a line break.
std::string RenderedLine(const RenderedEpisode& episode);
// kCorrupt: not such a line.
Result<RenderedEpisode> ParseRenderedLine(std::string_view line);

}  // namespace dadrl
