#include "actor/experience/kept_episodes.h"

#include <gmock/gmock.h>

#include "common/step/driving_shape.h"
#include "proto/experience.h"
#include "tests/driving_columns.h"

namespace dadrl {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class RecordingSink final : public ExperienceSink {
 public:
  std::vector<std::string> lines;
  bool is_blocked = false;

  void BeginEpisode(uint64_t episode) override { lines.push_back(fmt::format("begin {}", episode)); }
  void AddTransition(const Observation& observation, std::span<const float> decision, float reward,
                     uint8_t flags, uint32_t policy_version) override {
    lines.push_back(
        fmt::format("{} {} r{} f{} v{}", EgoOf(observation)[0], decision[1], reward, flags, policy_version));
  }
  void AddFinal(const Observation&) override { lines.emplace_back("final"); }
  void EndEpisode() override { lines.emplace_back("end"); }
  bool blocked() const override { return is_blocked; }
};

class KeptEpisodesTest : public testing::Test {
 protected:
  // An episode of two decisions; the first observation's first number is `number`.
  void Drive(ExperienceSink& sink, uint64_t episode, uint8_t end) {
    Observation observation{DrivingShape{}};
    EgoOf(observation)[0] = static_cast<float>(episode);
    sink.BeginEpisode(episode);
    const std::vector<float> decision = {0.5f, 0.25f};
    sink.AddTransition(observation, decision, 1.0f, 0, 7);
    EgoOf(observation)[0] += 0.5f;  // the caller's memory is its own
    sink.AddTransition(observation, decision, 2.0f, end, 8);
    if (end == kTruncated) sink.AddFinal(observation);
    sink.EndEpisode();
  }

  RecordingSink inner_;
};

TEST_F(KeptEpisodesTest, PassSuccessesOnAsTheyWereAndNothingElse) {
  const auto kept = MakeKeptEpisodes({.keep = KeptEpisodes::kSuccesses}, inner_);
  Drive(*kept, 1, kTerminated);
  Drive(*kept, 2, kTruncated);
  Drive(*kept, 3, 0);  // broken off
  EXPECT_THAT(inner_.lines, IsEmpty());
  Drive(*kept, 4, kTerminated | kSuccess);
  EXPECT_THAT(inner_.lines, ElementsAre("begin 4", "4 0.25 r1 f0 v7", "4.5 0.25 r2 f10 v8", "end"));
  inner_.is_blocked = true;
  EXPECT_TRUE(kept->blocked());
}

TEST_F(KeptEpisodesTest, NothingStandsBetweenWhereAllAreKept) {
  EXPECT_EQ(MakeKeptEpisodes({}, inner_), nullptr);
}

}  // namespace
}  // namespace dadrl
