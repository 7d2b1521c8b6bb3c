#include "actor/experience/kept_episodes.h"

#include "proto/experience.h"

namespace dadrl {

void KeptSuccesses::BeginEpisode(uint64_t episode) {
  episode_ = episode;
  frames_.clear();
}

void KeptSuccesses::AddTransition(const Observation& observation, std::span<const float> decision,
                                  float reward, uint8_t flags, uint32_t policy_version) {
  frames_.push_back({observation, {decision.begin(), decision.end()}, reward, flags, policy_version});
}

void KeptSuccesses::EndEpisode() {
  if (!frames_.empty() && (frames_.back().flags & kSuccess) != 0) {
    inner_.BeginEpisode(episode_);
    for (const Frame& frame : frames_) {
      inner_.AddTransition(frame.observation, frame.decision, frame.reward, frame.flags,
                           frame.policy_version);
    }
    inner_.EndEpisode();
  }
  frames_.clear();
}

std::unique_ptr<ExperienceSink> MakeKeptEpisodes(const ActorConfig& config, ExperienceSink& sink) {
  if (config.keep == KeptEpisodes::kAll) return nullptr;
  return std::make_unique<KeptSuccesses>(sink);
}

}  // namespace dadrl
