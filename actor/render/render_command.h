// `dadrl-actor render`: drives episodes and writes pictures of them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "actor/policies/driving_policy.h"
#include "common/config/config.h"
#include "common/util/result.h"
#include "proto/evaluation/rendered_episode.h"

namespace dadrl {

struct RenderOptions {
  Config config;
  std::string policy;  // as MakePolicy's name
  std::vector<uint64_t> seeds;
  // The ending chooses: ".svg" an animation, ".png" a strip of moments, "/" a folder that gets a
  // frame-STEP.svg for each moment. With `gallery` a folder that gets a SEED-OUTCOME.png, a strip, for each
  // episode.
  std::string out;
  bool gallery = false;
  std::optional<Outcome> outcome;  // of a gallery: only episodes that end so
  int every = 0;        // simulation steps between moments of an animation (0: 1) or of frames (0: 5)
  int moments = 6;      // of a strip
  double from_s = 0.0;  // part of the episode shown; a `to_s` beyond its end is its end
  std::optional<double> to_s;
};

// Called after each episode; false stops.
using OnRendered = std::function<bool(const RenderedEpisode&)>;

// Drives and draws the seeds in order in this process, which must not have an environment yet. Files are
// written atomically. An episode that the simulator loses has its error in the RenderedEpisode.
// kInvalidArgument: an unknown policy, scenario or ending of `out`, or an episode that ends before `from_s`;
// else what files fail with. Nothing is driven when `out` cannot be written.
Status RunRender(const RenderOptions& options, const OnRendered& on_rendered);

}  // namespace dadrl
