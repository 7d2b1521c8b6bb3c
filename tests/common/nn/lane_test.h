// Batches in vector lanes, for the tests: plain loops, no kernels.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "common/nn/aligned_buffer.h"
#include "common/nn/linear.h"

namespace dadrl::nn {

inline int BlocksOf(int samples) { return (samples + kLanes - 1) / kLanes; }

// [samples, features] rows to [blocks][features][16], the rest zero.
inline FloatBuffer ToLaneBuffer(const std::vector<float>& rows, int samples, int features) {
  FloatBuffer lanes(static_cast<size_t>(BlocksOf(samples) * features * kLanes));
  for (int i = 0; i < samples; ++i) {
    for (int f = 0; f < features; ++f) {
      lanes.data()[(i / kLanes * features + f) * kLanes + i % kLanes] =
          rows[static_cast<size_t>(i * features + f)];
    }
  }
  return lanes;
}

inline std::vector<float> ToRowVector(LaneSpan lanes, int samples, int features) {
  std::vector<float> rows(static_cast<size_t>(samples * features));
  for (int i = 0; i < samples; ++i) {
    for (int f = 0; f < features; ++f) {
      rows[static_cast<size_t>(i * features + f)] = lanes.block(i / kLanes)[f * kLanes + i % kLanes];
    }
  }
  return rows;
}

inline FloatBuffer LaneBuffer(int samples, int features) {
  return FloatBuffer(static_cast<size_t>(BlocksOf(samples) * features * kLanes));
}

// Runs each test once for every instruction set; skips those this processor lacks.
class EveryIsa : public testing::TestWithParam<Isa> {
 protected:
  void SetUp() override {
    if (GetParam() > DetectIsa()) GTEST_SKIP() << "this processor lacks " << IsaName(GetParam());
  }
  const LaneKernels& kernels() const { return LaneKernelsFor(GetParam()); }
};

inline auto AllIsas() { return testing::Values(Isa::kScalar, Isa::kAvx2, Isa::kAvx512); }
inline std::string IsaTestName(const testing::TestParamInfo<Isa>& info) {
  return std::string(IsaName(info.param));
}

}  // namespace dadrl::nn
