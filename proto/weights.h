// The broadcast policy, held against what its receiver expects.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "cluster.h"
#include "common/util/result.h"

namespace dadrl {

// No network that trains has a larger parameter, and with smaller ones no layer's sum overflows.
constexpr float kMaxParameter = 1e4f;

inline std::span<const std::byte> ParameterBytes(const dadrl_idl_Weights& weights) {
  return {reinterpret_cast<const std::byte*>(weights.parameters._buffer), weights.parameters._length};
}

// kInvalidArgument: of another network, with the remedy. kCorrupt: version 0, another length, a checksum that
// does not fit, a parameter that is not finite or beyond kMaxParameter.
Status CheckWeights(const dadrl_idl_Weights& weights, size_t parameter_count, uint64_t layout_hash);

}  // namespace dadrl
