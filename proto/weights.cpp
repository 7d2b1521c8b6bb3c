#include "proto/weights.h"

#include <cmath>
#include <cstring>

#include "common/io/checksum.h"

namespace dadrl {
namespace {

// The index of the first parameter that no network has, or `count`. The bytes may lie anywhere.
size_t FirstImpossible(std::span<const std::byte> bytes, size_t count) {
  for (size_t i = 0; i < count; ++i) {
    float value = 0.0f;
    std::memcpy(&value, &bytes[i * sizeof(float)], sizeof(value));
    if (!(std::abs(value) <= kMaxParameter)) return i;
  }
  return count;
}

}  // namespace

Status CheckWeights(const dadrl_idl_Weights& weights, size_t parameter_count, uint64_t layout_hash) {
  if (weights.layout_hash != layout_hash) {
    return Fail(ErrorCode::kInvalidArgument,
                "version {} is of another network (layout {:016x}, ours {:016x}): start this actor with the "
                "configuration of the learner",
                weights.version, weights.layout_hash, layout_hash);
  }
  const std::span<const std::byte> bytes = ParameterBytes(weights);
  if (bytes.size() != parameter_count * sizeof(float)) {
    return Fail(ErrorCode::kCorrupt, "version {} has {} bytes, not {}", weights.version, bytes.size(),
                parameter_count * sizeof(float));
  }
  if (weights.version == 0) return Fail(ErrorCode::kCorrupt, "version 0 does not exist");
  if (Xxh3(bytes) != weights.checksum) {
    return Fail(ErrorCode::kCorrupt, "the checksum of version {} does not fit", weights.version);
  }
  const size_t impossible = FirstImpossible(bytes, parameter_count);
  if (impossible == parameter_count) return {};
  return Fail(ErrorCode::kCorrupt, "parameter {} of version {} is not finite or beyond {:g}", impossible,
              weights.version, kMaxParameter);
}

}  // namespace dadrl
