// The lane kernels against plain loops in double.
#include "common/nn/lanes/lane_kernels.h"

#include <cmath>

#include "tests/common/nn/lane_test.h"
#include "tests/golden/golden.h"

namespace dadrl::nn {
namespace {

using golden::Uniform;

using LaneKernelsTest = EveryIsa;

// C as `multiply` defines it, in double.
std::vector<double> Expected(const Product& p, const std::vector<float>& c_before) {
  std::vector<double> c(c_before.begin(), c_before.end());
  for (int n = 0; n < p.blocks; ++n) {
    for (int i = 0; i < p.rows; ++i) {
      for (int lane = 0; lane < (n + 1 == p.blocks ? p.last_width : kLanes); ++lane) {
        double sum = p.bias == nullptr ? 0.0 : p.bias[i];
        for (int s = 0; s < p.segments; ++s) {
          for (int k = 0; k < p.depth; ++k) {
            sum += static_cast<double>(p.a[i * p.a_row + k * p.a_depth + s * p.a_segment]) *
                   static_cast<double>(p.b[n * p.b_block + k * p.b_depth + s * p.b_segment + lane]);
          }
        }
        double& to = c[static_cast<size_t>(n * p.c_block + i * p.c_row + lane)];
        to = p.accumulate ? to + sum : sum;
        if (p.relu) to = std::max(to, 0.0);
      }
    }
  }
  return c;
}

void Check(const LaneKernels& kernels, Product p, size_t c_size) {
  const std::vector<float> before = Uniform(3, c_size);
  std::vector<float> c = before;
  p.c = c.data();
  kernels.multiply(p);
  const std::vector<double> expected = Expected(p, before);
  for (size_t i = 0; i < c_size; ++i) {
    ASSERT_NEAR(c[i], expected[i], 1e-5) << "rows " << p.rows << " blocks " << p.blocks << " at " << i;
  }
}

TEST_P(LaneKernelsTest, MultipliesEveryTileShape) {
  for (const int rows : {1, 2, 3, 5, 8, 12, 15, 23, 30}) {
    for (const int blocks : {1, 2, 3, 8, 9}) {
      constexpr int kDepth = 7;
      const std::vector<float> a = Uniform(1, static_cast<size_t>(rows * kDepth));
      const std::vector<float> b = Uniform(2, static_cast<size_t>(blocks * kDepth * kLanes));
      const std::vector<float> bias = Uniform(4, static_cast<size_t>(rows));
      const size_t c_size = static_cast<size_t>(blocks * rows * kLanes);
      Product p{.rows = rows,
                .blocks = blocks,
                .depth = kDepth,
                .a = a.data(),
                .a_row = kDepth,
                .a_depth = 1,
                .b = b.data(),
                .b_block = kDepth * kLanes,
                .b_depth = kLanes,
                .c_block = rows * kLanes,
                .c_row = kLanes,
                .bias = bias.data()};
      Check(kernels(), p, c_size);
      p.relu = true;
      Check(kernels(), p, c_size);
      p.accumulate = true;
      p.bias = nullptr;
      Check(kernels(), p, c_size);
    }
  }
}

TEST_P(LaneKernelsTest, AddsWeightGradientsWithoutTouchingBeyondTheirRow) {
  for (const int inputs : {1, 7, 16, 20, 33}) {
    constexpr int kRows = 13;
    constexpr int kSegments = 3;
    const int row = static_cast<int>(RoundUp(static_cast<size_t>(inputs), kLanes));
    const std::vector<float> a = Uniform(1, size_t{kSegments} * kRows * kLanes);
    const std::vector<float> b = Uniform(2, static_cast<size_t>(kSegments * kLanes * row));
    Check(kernels(),
          {.rows = kRows,
           .blocks = row / kLanes,
           .depth = kLanes,
           .segments = kSegments,
           .a = a.data(),
           .a_row = kLanes,
           .a_depth = 1,
           .a_segment = kRows * kLanes,
           .b = b.data(),
           .b_block = kLanes,
           .b_depth = row,
           .b_segment = ptrdiff_t{row} * kLanes,
           .c_block = kLanes,
           .c_row = inputs,
           .accumulate = true,
           .last_width = inputs - row + kLanes},
          static_cast<size_t>(kRows * inputs));
  }
}

TEST_P(LaneKernelsTest, TransposesThereAndBack) {
  for (const int features : {1, 15, 16, 17, 40}) {
    for (const int samples : {16, 5, 0}) {
      const std::vector<float> rows = Uniform(5, static_cast<size_t>(kLanes * features));
      FloatBuffer lanes(static_cast<size_t>(features * kLanes));
      kernels().to_lanes(rows.data(), features, samples, features, lanes.data());
      for (int i = 0; i < kLanes * features; ++i) {
        const int sample = i % kLanes;
        const float expected =
            sample < samples ? rows[static_cast<size_t>(sample * features + i / kLanes)] : 0.0f;
        ASSERT_EQ(lanes.data()[i], expected);
      }
      const auto stride = static_cast<ptrdiff_t>(RoundUp(static_cast<size_t>(features), kLanes));
      FloatBuffer back(static_cast<size_t>(stride * kLanes));
      std::ranges::fill(back.span(), 9.0f);
      kernels().to_rows(lanes.data(), features, back.data(), stride);
      for (int sample = 0; sample < kLanes; ++sample) {
        for (int f = 0; f < stride; ++f) {
          const float expected =
              f < features && sample < samples ? rows[static_cast<size_t>(sample * features + f)] : 0.0f;
          ASSERT_EQ(back.data()[sample * stride + f], expected);
        }
      }
    }
  }
}

TEST_P(LaneKernelsTest, SumsSamplesOntoWhatIsThere) {
  constexpr int kFeatures = 21;
  const std::vector<float> gradient = Uniform(6, size_t{2} * kFeatures * kLanes);
  std::vector<float> sums(kFeatures + 1, 1.0f);
  kernels().sum_samples(gradient.data(), kFeatures * kLanes, 2, kFeatures, sums.data());
  for (int f = 0; f < kFeatures; ++f) {
    double expected = 1.0;
    for (int b = 0; b < 2; ++b) {
      for (int i = 0; i < kLanes; ++i) {
        expected += static_cast<double>(gradient[static_cast<size_t>((b * kFeatures + f) * kLanes + i)]);
      }
    }
    EXPECT_NEAR(sums[static_cast<size_t>(f)], expected, 1e-5);
  }
  EXPECT_EQ(sums.back(), 1.0f);
}

TEST_P(LaneKernelsTest, LstmCellStaysDefinedForHugeSums) {
  FloatBuffer gates(4 * kLanes), cell(kLanes), cell_tanh(kLanes), hidden(kLanes);
  for (size_t i = 0; i < gates.size(); ++i) gates.data()[i] = i % 2 == 0 ? 1e30f : -1e30f;
  kernels().lstm_forward({.units = 1,
                          .gates = gates.data(),
                          .cell = cell.data(),
                          .cell_tanh = cell_tanh.data(),
                          .hidden = hidden.data()});
  for (int i = 0; i < kLanes; ++i) EXPECT_NEAR(hidden.data()[i], i % 2 == 0 ? std::tanh(1.0) : 0.0, 1e-6);
}

// A NaN must reach the loss, where it is reported, and not be rectified or clamped away.
TEST_P(LaneKernelsTest, NanPassesThroughEveryActivation) {
  FloatBuffer values(kLanes);
  values.data()[3] = std::nanf("");
  kernels().relu(values.data(), values.data(), kLanes);
  EXPECT_TRUE(std::isnan(values.data()[3]));
  EXPECT_FALSE(std::isnan(values.data()[4]));
  FloatBuffer gates(4 * kLanes), cell(kLanes), cell_tanh(kLanes), hidden(kLanes);
  gates.data()[3 * kLanes + 3] = std::nanf("");
  kernels().lstm_forward({.units = 1,
                          .gates = gates.data(),
                          .cell = cell.data(),
                          .cell_tanh = cell_tanh.data(),
                          .hidden = hidden.data()});
  EXPECT_TRUE(std::isnan(hidden.data()[3]));
  EXPECT_FALSE(std::isnan(hidden.data()[4]));
}

INSTANTIATE_TEST_SUITE_P(Isa, LaneKernelsTest, AllIsas(), IsaTestName);

}  // namespace
}  // namespace dadrl::nn
