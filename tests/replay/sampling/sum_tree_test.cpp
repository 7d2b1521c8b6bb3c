#include "replay/sampling/sum_tree.h"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "common/util/random.h"

namespace dadrl {
namespace {

size_t NaiveFind(const std::vector<double>& weights, double value) {
  size_t last = 0;
  for (size_t i = 0; i < weights.size(); ++i) {
    if (weights[i] <= 0.0) continue;
    last = i;
    if (value < weights[i]) return i;
    value -= weights[i];
  }
  return last;
}

TEST(SumTree, AgreesWithPlainSumsWhileItGrows) {
  // Whole weights, so that both sum without rounding and must agree exactly.
  Random random(1);
  SumTree tree;
  std::vector<double> weights;
  for (int round = 0; round < 20000; ++round) {
    const size_t index = random.Below(static_cast<uint64_t>(1 + round / 4));
    const auto weight = static_cast<double>(random.Below(10));
    if (index >= weights.size()) weights.resize(index + 1, 0.0);
    weights[index] = weight;
    tree.Set(index, weight);
    if (round % 50 != 0) continue;
    const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
    ASSERT_EQ(tree.total(), total);
    if (total == 0.0) continue;
    const double value = random.Uniform() * total;
    ASSERT_EQ(tree.Find(value), NaiveFind(weights, value));
    ASSERT_EQ(tree.Get(index), weight);
  }
}

TEST(SumTree, GrowsInOneLeapAndKeepsWhatItHeld) {
  SumTree tree;
  tree.Set(3, 2.0);
  tree.Set(100000, 5.0);
  EXPECT_EQ(tree.total(), 7.0);
  EXPECT_EQ(tree.Find(1.9), 3u);
  EXPECT_EQ(tree.Find(2.1), 100000u);
  EXPECT_EQ(tree.Get(99999), 0.0);
}

TEST(SumTree, NeverSamplesAWeightOfZeroHoweverItRounds) {
  SumTree tree;
  for (size_t i = 0; i < 1000; ++i) tree.Set(i, i % 7 == 3 ? 0.1 : 0.0);
  Random random(2);
  for (int i = 0; i < 10000; ++i) EXPECT_EQ(tree.Find(random.Uniform() * tree.total()) % 7, 3u);
  EXPECT_EQ(tree.Find(tree.total()) % 7, 3u);
}

TEST(SumTree, SumsDoNotDrift) {
  SumTree tree;
  Random random(3);
  for (int i = 0; i < 200000; ++i) tree.Set(random.Below(100), random.Uniform() * 1e6);
  for (size_t i = 0; i < 100; ++i) tree.Set(i, 0.0);
  EXPECT_EQ(tree.total(), 0.0);
}

}  // namespace
}  // namespace dadrl
