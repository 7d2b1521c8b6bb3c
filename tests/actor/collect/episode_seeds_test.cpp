#include "actor/collect/episode_seeds.h"

#include <gtest/gtest.h>

#include <set>

#include "proto/evaluation/episode_line.h"

namespace dadrl {
namespace {

TEST(TrainingSeed, StaysBelowTheSeedsOfEvaluation) {
  for (uint64_t episode = 1; episode <= 10000; ++episode) {
    EXPECT_LT(TrainingSeed(1, 0, 42, episode), kFirstEvaluationSeed);
  }
}

TEST(TrainingSeed, IsTheSameForTheSameEpisode) {
  EXPECT_EQ(TrainingSeed(1, 2, 3, 4), TrainingSeed(1, 2, 3, 4));
}

TEST(TrainingSeed, DiffersBetweenRunsActorsIncarnationsAndEpisodes) {
  std::set<uint64_t> seeds;
  int drawn = 0;
  for (uint64_t run : {1u, 2u}) {
    for (uint32_t actor : {0u, 1u, 2u}) {
      for (uint64_t incarnation : {100u, 101u}) {
        for (uint64_t episode = 1; episode <= 20; ++episode, ++drawn) {
          seeds.insert(TrainingSeed(run, actor, incarnation, episode));
        }
      }
    }
  }
  // 240 draws out of a million collide 0.03 times on average.
  EXPECT_GE(seeds.size(), static_cast<size_t>(drawn) - 1);
}

TEST(ActionSeed, IsNoTrafficSeedAndDiffersBetweenActors) {
  EXPECT_NE(ActionSeed(1, 0, 5), ActionSeed(1, 1, 5));
  EXPECT_NE(ActionSeed(1, 0, 5), ActionSeed(1, 0, 6));
}

}  // namespace
}  // namespace dadrl
