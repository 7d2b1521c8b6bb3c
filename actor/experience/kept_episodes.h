// Which episodes an actor stores.
#pragma once

#include <memory>
#include <vector>

#include "actor/experience/experience_sink.h"
#include "common/config/config.h"

namespace dadrl {

// Holds an episode back until its end, and passes it on if it is a success. Not thread safe; borrows `inner`.
class KeptSuccesses final : public ExperienceSink {
 public:
  explicit KeptSuccesses(ExperienceSink& inner) : inner_(inner) {}

  void BeginEpisode(uint64_t episode) override;
  void AddTransition(const Observation& observation, std::span<const float> decision, float reward,
                     uint8_t flags, uint32_t policy_version) override;
  void AddFinal(const Observation&) override { frames_.clear(); }  // truncated: no success
  void EndEpisode() override;
  bool blocked() const override { return inner_.blocked(); }

 private:
  struct Frame {
    Observation observation;
    std::vector<float> decision;
    float reward;
    uint8_t flags;
    uint32_t policy_version;
  };

  ExperienceSink& inner_;
  uint64_t episode_ = 0;
  std::vector<Frame> frames_;
};

// What stands between a collector and `sink` for actor.keep; null where nothing does.
std::unique_ptr<ExperienceSink> MakeKeptEpisodes(const ActorConfig& config, ExperienceSink& sink);

}  // namespace dadrl
