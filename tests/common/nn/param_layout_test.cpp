#include "common/nn/param_layout.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/nn/aligned_buffer.h"

namespace dadrl::nn {
namespace {

ParamLayout Example() {
  ParamLayout layout;
  layout.Add("a.weight", {3, 7}, 0.5f);
  layout.Add("a.bias", {3}, 0.25f);
  return layout;
}

TEST(ParamLayoutTest, PadsEveryTensorToACacheLine) {
  const ParamLayout layout = Example();
  EXPECT_EQ(layout.Find("a.weight")->offset, 0u);
  EXPECT_EQ(layout.Find("a.weight")->size, 21u);
  EXPECT_EQ(layout.Find("a.bias")->offset, 32u);
  EXPECT_EQ(layout.size(), 48u);
  EXPECT_EQ(layout.Find("b"), nullptr);
}

TEST(ParamLayoutTest, HashChangesWithNamesAndShapes) {
  EXPECT_EQ(Example().hash(), Example().hash());
  ParamLayout renamed;
  renamed.Add("b.weight", {3, 7}, 0.5f);
  renamed.Add("a.bias", {3}, 0.25f);
  EXPECT_NE(renamed.hash(), Example().hash());
  ParamLayout reshaped;
  reshaped.Add("a.weight", {7, 3}, 0.5f);
  reshaped.Add("a.bias", {3}, 0.25f);
  EXPECT_NE(reshaped.hash(), Example().hash());
}

TEST(ParamLayoutTest, InitialisesWithinBoundsAndRepeatably) {
  const ParamLayout layout = Example();
  std::vector<float> first(layout.size(), 9.0f), second(layout.size()), other(layout.size());
  layout.Initialize(7, first);
  layout.Initialize(7, second);
  layout.Initialize(8, other);
  EXPECT_EQ(first, second);
  EXPECT_NE(first, other);
  float largest = 0.0f;
  for (size_t i = 0; i < 21; ++i) largest = std::max(largest, std::abs(first[i]));
  EXPECT_LE(largest, 0.5f);
  EXPECT_GT(largest, 0.25f);
  for (size_t i = 21; i < 32; ++i) EXPECT_EQ(first[i], 0.0f) << "padding";
}

TEST(ParamLayoutTest, NamesTheTensorThatIsNotFinite) {
  const ParamLayout layout = Example();
  std::vector<float> parameters(layout.size());
  EXPECT_EQ(layout.FirstNonFinite(parameters), "");
  parameters[34] = HUGE_VALF;
  EXPECT_EQ(layout.FirstNonFinite(parameters), "a.bias");
  parameters[20] = std::nanf("");
  EXPECT_EQ(layout.FirstNonFinite(parameters), "a.weight");
}

TEST(ArenaTest, MeasuresThenHandsOutAlignedMemory) {
  const auto lay_out = [](Arena& arena) {
    return std::vector<float*>{arena.Allocate(5), arena.Allocate(17)};
  };
  Arena measure;
  lay_out(measure);
  EXPECT_EQ(measure.used(), 48u);
  Arena arena(measure.used());
  for (float* pointer : lay_out(arena)) EXPECT_EQ(reinterpret_cast<uintptr_t>(pointer) % kAlignment, 0u);
}

TEST(ArenaDeathTest, RefusesToGrow) {
  Arena arena(16);
  arena.Allocate(16);
  EXPECT_DEATH(arena.Allocate(1), "");
}

}  // namespace
}  // namespace dadrl::nn
