#include "common/nn/param_layout.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/nn/aligned_buffer.h"
#include "common/util/random.h"

namespace dadrl::nn {
namespace {

uint64_t Fnv1a(uint64_t hash, const void* data, size_t bytes) {
  const auto* byte = static_cast<const unsigned char*>(data);
  for (size_t i = 0; i < bytes; ++i) hash = (hash ^ byte[i]) * 0x100000001b3u;
  return hash;
}

uint64_t Fnv1a(uint64_t hash, uint64_t value) { return Fnv1a(hash, &value, sizeof(value)); }

}  // namespace

size_t ParamLayout::Add(std::string name, std::vector<int> shape, float initial_bound) {
  const size_t size = std::accumulate(shape.begin(), shape.end(), size_t{1},
                                      [](size_t product, int n) { return product * static_cast<size_t>(n); });
  const size_t offset = size_;
  tensors_.push_back({std::move(name), std::move(shape), offset, size, initial_bound});
  size_ += RoundUp(size, kAlignedFloats);
  return offset;
}

const TensorInfo* ParamLayout::Find(std::string_view name) const {
  const auto found = std::find_if(tensors_.begin(), tensors_.end(),
                                  [&](const TensorInfo& tensor) { return tensor.name == name; });
  return found == tensors_.end() ? nullptr : &*found;
}

uint64_t ParamLayout::hash() const {
  uint64_t hash = 0xcbf29ce484222325u;
  for (const TensorInfo& tensor : tensors_) {
    hash = Fnv1a(hash, tensor.name.data(), tensor.name.size());
    hash = Fnv1a(hash, tensor.shape.size());
    for (const int extent : tensor.shape) hash = Fnv1a(hash, static_cast<uint64_t>(extent));
    hash = Fnv1a(hash, tensor.offset);
  }
  return hash;
}

void ParamLayout::Initialize(uint64_t seed, std::span<float> parameters) const {
  std::fill(parameters.begin(), parameters.end(), 0.0f);
  Random random(seed);
  for (const TensorInfo& tensor : tensors_) {
    for (float& value : parameters.subspan(tensor.offset, tensor.size)) {
      value = random.Uniform(-tensor.initial_bound, tensor.initial_bound);
    }
  }
}

std::string_view ParamLayout::FirstNonFinite(std::span<const float> parameters) const {
  for (const TensorInfo& tensor : tensors_) {
    if (!AllFinite(parameters.subspan(tensor.offset, tensor.size))) return tensor.name;
  }
  return {};
}

bool AllFinite(std::span<const float> values) {
  // Zero times a finite number is zero; anything else leaves a NaN in the sum. Sixteen sums let it vectorise.
  float sums[16] = {};
  size_t i = 0;
  for (; i + 16 <= values.size(); i += 16) {
    for (size_t j = 0; j < 16; ++j) sums[j] += values[i + j] * 0.0f;
  }
  for (; i < values.size(); ++i) sums[0] += values[i] * 0.0f;
  for (const float sum : sums) {
    if (std::isnan(sum)) return false;
  }
  return true;
}

}  // namespace dadrl::nn
