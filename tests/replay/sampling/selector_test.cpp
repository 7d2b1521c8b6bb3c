#include "replay/sampling/selector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

namespace dadrl {
namespace {

// Upper 0.1 % point of chi-square (Wilson and Hilferty's approximation).
double ChiSquareLimit(double degrees) {
  const double t = 1.0 - 2.0 / (9.0 * degrees) + 3.09 * std::sqrt(2.0 / (9.0 * degrees));
  return degrees * t * t * t;
}

// Samples and compares the counts with `expected` probabilities by slot; also checks each reported
// probability.
void ExpectDistribution(Selector& selector, const std::map<uint32_t, double>& expected, uint64_t seed) {
  constexpr int kSamples = 200000;
  Random random(seed);
  std::map<uint32_t, int> counts;
  for (int i = 0; i < kSamples; ++i) {
    const Selector::Choice choice = selector.Sample(random);
    ASSERT_TRUE(expected.contains(choice.slot)) << choice.slot;
    ASSERT_NEAR(choice.probability, expected.at(choice.slot), 1e-9);
    ++counts[choice.slot];
  }
  double chi_square = 0.0;
  for (const auto& [slot, probability] : expected) {
    const double mean = kSamples * probability;
    chi_square += (counts[slot] - mean) * (counts[slot] - mean) / mean;
  }
  EXPECT_LT(chi_square, ChiSquareLimit(static_cast<double>(expected.size() - 1)));
}

TEST(UniformSelector, SamplesEveryItemAlikeAfterInsertsAndDeletes) {
  const auto selector = MakeSelector(SamplerKind::kUniform, 0.0);
  std::map<uint32_t, double> expected;
  for (uint32_t slot = 0; slot < 300; ++slot) selector->Insert(slot, 1.0);
  for (uint32_t slot = 0; slot < 300; ++slot) {
    if (slot % 3 == 0) {
      selector->Delete(slot);
    } else {
      expected[slot] = 1.0 / 200.0;
    }
  }
  ASSERT_EQ(selector->size(), 200u);
  ExpectDistribution(*selector, expected, 1);
}

TEST(PrioritizedSelector, SamplesInProportionToThePowerOfThePriority) {
  constexpr double kAlpha = 0.6;
  const auto selector = MakeSelector(SamplerKind::kPrioritized, kAlpha);
  std::map<uint32_t, double> expected;
  double total = 0.0;
  for (uint32_t slot = 0; slot < 100; ++slot) {
    selector->Insert(slot, 1.0);
    if (slot % 5 == 0) selector->Delete(slot);
  }
  for (uint32_t slot = 0; slot < 100; ++slot) {
    if (slot % 5 == 0) continue;
    const double priority = 0.01 + slot % 17;
    selector->Update(slot, priority);
    expected[slot] = std::pow(priority, kAlpha);
    total += expected[slot];
  }
  for (auto& [slot, probability] : expected) probability /= total;
  ExpectDistribution(*selector, expected, 2);
}

TEST(PrioritizedSelector, AnItemWithoutErrorIsStillThere) {
  const auto selector = MakeSelector(SamplerKind::kPrioritized, 0.6);
  selector->Insert(7, 0.0);
  Random random(3);
  EXPECT_EQ(selector->Sample(random).slot, 7u);
  EXPECT_EQ(selector->Sample(random).probability, 1.0);
}

class OrderedSelectors : public testing::TestWithParam<SamplerKind> {};
INSTANTIATE_TEST_SUITE_P(Both, OrderedSelectors,
                         testing::Values(SamplerKind::kNewestFirst, SamplerKind::kOldestFirst));

TEST_P(OrderedSelectors, AgreeWithAPlainListUnderRandomOperations) {
  const auto selector = MakeSelector(GetParam(), 0.0);
  std::vector<uint32_t> naive;  // oldest first
  Random random(4);
  for (int round = 0; round < 20000; ++round) {
    const auto slot = static_cast<uint32_t>(random.Below(200));
    const auto found = std::find(naive.begin(), naive.end(), slot);
    if (found == naive.end()) {
      selector->Insert(slot, 1.0);
      naive.push_back(slot);
    } else {
      selector->Delete(slot);
      naive.erase(found);
    }
    ASSERT_EQ(selector->size(), naive.size());
    if (naive.empty()) continue;
    const Selector::Choice choice = selector->Sample(random);
    ASSERT_EQ(choice.slot, GetParam() == SamplerKind::kNewestFirst ? naive.back() : naive.front());
    ASSERT_EQ(choice.probability, 1.0);
  }
}

class PrioritySelectors : public testing::TestWithParam<SamplerKind> {};
INSTANTIATE_TEST_SUITE_P(Both, PrioritySelectors,
                         testing::Values(SamplerKind::kHighestPriority, SamplerKind::kLowestPriority));

TEST_P(PrioritySelectors, AgreeWithAPlainListUnderRandomOperations) {
  const bool highest = GetParam() == SamplerKind::kHighestPriority;
  const auto selector = MakeSelector(GetParam(), 0.6);
  struct Entry {
    uint32_t slot;
    double priority;
  };
  std::vector<Entry> naive;  // in the order of their last change
  Random random(6);
  for (int round = 0; round < 20000; ++round) {
    const auto slot = static_cast<uint32_t>(random.Below(200));
    // Few values, so that there are many equals.
    const double priority = static_cast<double>(random.Below(20));
    const auto found =
        std::find_if(naive.begin(), naive.end(), [&](const Entry& entry) { return entry.slot == slot; });
    if (found == naive.end()) {
      selector->Insert(slot, priority);
      naive.push_back({slot, priority});
    } else if (naive.erase(found); random.Uniform() < 0.5) {
      selector->Update(slot, priority);
      naive.push_back({slot, priority});
    } else {
      selector->Delete(slot);
    }
    ASSERT_EQ(selector->size(), naive.size());
    if (naive.empty()) continue;
    // The first of the extreme ones.
    const auto best = std::min_element(naive.begin(), naive.end(), [&](const Entry& a, const Entry& b) {
      return highest ? a.priority > b.priority : a.priority < b.priority;
    });
    const Selector::Choice choice = selector->Sample(random);
    ASSERT_EQ(choice.slot, best->slot);
    ASSERT_EQ(choice.probability, 1.0);
  }
}

class AllSelectors : public testing::TestWithParam<SamplerKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, AllSelectors,
                         testing::Values(SamplerKind::kUniform, SamplerKind::kPrioritized,
                                         SamplerKind::kNewestFirst, SamplerKind::kOldestFirst,
                                         SamplerKind::kHighestPriority, SamplerKind::kLowestPriority));

TEST_P(AllSelectors, ManySamplesAreThoseOfOneAfterTheOther) {
  const auto selector = MakeSelector(GetParam(), 0.7);
  Random priorities(3);
  for (uint32_t slot = 0; slot < 1000; ++slot) selector->Insert(slot, priorities.Uniform(0.0, 5.0));
  for (uint32_t slot = 0; slot < 1000; slot += 3) selector->Delete(slot);
  Random one(4);
  Random many(4);
  std::vector<Selector::Choice> choices(300);
  selector->SampleMany(many, choices);
  for (const Selector::Choice& choice : choices) {
    const Selector::Choice expected = selector->Sample(one);
    ASSERT_EQ(choice.slot, expected.slot);
    ASSERT_EQ(choice.probability, expected.probability);
  }
  EXPECT_EQ(one.state(), many.state());
}

TEST_P(AllSelectors, SampleOnlyWhatIsInUnderRandomOperations) {
  const auto selector = MakeSelector(GetParam(), 0.7);
  std::vector<bool> in(500, false);
  size_t size = 0;
  Random random(5);
  for (int round = 0; round < 50000; ++round) {
    const auto slot = static_cast<uint32_t>(random.Below(in.size()));
    if (!in[slot]) {
      selector->Insert(slot, random.Uniform(0.0, 5.0));
      ++size;
    } else if (random.Uniform() < 0.5) {
      selector->Update(slot, random.Uniform(0.0, 5.0));
      continue;
    } else {
      selector->Delete(slot);
      --size;
    }
    in[slot] = !in[slot];
    ASSERT_EQ(selector->size(), size);
    if (size > 0) {
      ASSERT_TRUE(in[selector->Sample(random).slot]);
    }
  }
}

}  // namespace
}  // namespace dadrl
