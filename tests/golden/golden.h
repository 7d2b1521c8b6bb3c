// Reads the golden files (make_golden.py) and repeats the hash their inputs come from.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/io/npy.h"
#include "common/nn/param_layout.h"
#include "tests/paths.h"

namespace dadrl::golden {

// The numbers of tests/golden/<name>.npy.
template <typename T>
std::vector<T> Numbers(const std::string& name) {
  const std::string path = std::string(DADRL_SOURCE_DIR) + "/tests/golden/" + name + ".npy";
  auto array = ReadNpy<T>(path, uint64_t{1} << 30);
  if (!array) {
    ADD_FAILURE() << array.error().message;
    return {};
  }
  return std::move(array->values);
}

inline std::vector<float> Floats(const std::string& name) { return Numbers<float>(name); }
inline std::vector<uint8_t> Bytes(const std::string& name) { return Numbers<uint8_t>(name); }

// The `uniform` of make_golden.py: values in [-scale, scale).
inline std::vector<float> Uniform(uint64_t salt, size_t count, float scale = 1.0f) {
  std::vector<float> values(count);
  for (size_t i = 0; i < count; ++i) {
    uint64_t z = (i + 1) * 0x9e3779b97f4a7c15u + salt * 0xd1342543de82ef95u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    z ^= z >> 31;
    values[i] = (static_cast<float>(z >> 40) * 0x1p-23f - 1.0f) * scale;
  }
  return values;
}

// Fills a flat vector as the `make_parameters` of make_golden.py does: within each tensor's initial bound.
inline void FillParameters(const nn::ParamLayout& layout, uint64_t salt, std::span<float> parameters) {
  uint64_t index = 0;
  for (const nn::TensorInfo& tensor : layout.tensors()) {
    const std::vector<float> values = Uniform(salt * 1000 + index++, tensor.size, tensor.initial_bound);
    std::copy(values.begin(), values.end(), parameters.begin() + static_cast<ptrdiff_t>(tensor.offset));
  }
}

// Largest difference over the largest golden magnitude.
inline double RelativeError(std::span<const float> ours, std::span<const float> golden) {
  EXPECT_EQ(ours.size(), golden.size());
  double difference = 0.0;
  double magnitude = 0.0;
  for (size_t i = 0; i < std::min(ours.size(), golden.size()); ++i) {
    const double distance = std::abs(static_cast<double>(ours[i]) - static_cast<double>(golden[i]));
    difference = std::isnan(distance) ? HUGE_VAL : std::max(difference, distance);
    magnitude = std::max(magnitude, std::abs(static_cast<double>(golden[i])));
  }
  return magnitude == 0.0 ? difference : difference / magnitude;
}

constexpr double kTolerance = 1e-5;

inline void ExpectAgrees(std::span<const float> ours, std::span<const float> golden, const std::string& what,
                         double tolerance = kTolerance) {
  EXPECT_LE(RelativeError(ours, golden), tolerance) << what;
}

// Compares tensor by tensor, from tensor `first` on; `golden` holds them one behind the other without
// padding.
inline void ExpectTensorsAgree(const nn::ParamLayout& layout, std::span<const float> ours,
                               std::span<const float> golden, const std::string& what, size_t first = 0,
                               double tolerance = kTolerance) {
  size_t at = 0;
  for (const nn::TensorInfo& tensor : layout.tensors().subspan(first)) {
    ASSERT_LE(at + tensor.size, golden.size()) << what << " ends before " << tensor.name;
    ExpectAgrees(ours.subspan(tensor.offset, tensor.size), golden.subspan(at, tensor.size),
                 what + " " + tensor.name, tolerance);
    at += tensor.size;
  }
  EXPECT_EQ(at, golden.size()) << what;
}

// The same where `golden` holds every `step`th number of each tensor.
inline void ExpectEveryNthAgrees(const nn::ParamLayout& layout, std::span<const float> ours,
                                 std::span<const float> golden, size_t step, size_t first = 0) {
  for (const nn::TensorInfo& tensor : layout.tensors().subspan(first)) {
    std::vector<float> some;
    for (size_t i = 0; i < tensor.size; i += step) some.push_back(ours[tensor.offset + i]);
    ASSERT_LE(some.size(), golden.size()) << "the file ends before " << tensor.name;
    ExpectAgrees(some, golden.first(some.size()), tensor.name);
    golden = golden.subspan(some.size());
  }
  EXPECT_TRUE(golden.empty());
}

}  // namespace dadrl::golden
