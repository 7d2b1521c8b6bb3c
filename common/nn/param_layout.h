// One network = one flat parameter vector; this table says which tensor lies where.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace dadrl::nn {

// Tensors are row-major float32; each starts on a 64-byte boundary and the gap behind it is zero and stays
// zero.
struct TensorInfo {
  std::string name;  // dotted, "encoder.stae.lstm.weight_ih"
  std::vector<int> shape;
  size_t offset = 0;           // in floats
  size_t size = 0;             // in floats, without padding
  float initial_bound = 0.0f;  // a fresh tensor is uniform in [-bound, bound)
};

// Append-only; immutable once its networks are built. Optimiser moments, gradients and target copies use the
// same one.
class ParamLayout {
 public:
  // Appends a tensor and returns its offset.
  size_t Add(std::string name, std::vector<int> shape, float initial_bound);

  std::span<const TensorInfo> tensors() const { return tensors_; }
  const TensorInfo* Find(std::string_view name) const;
  // Floats of the flat vector, padding included.
  size_t size() const { return size_; }
  // FNV-1a over names, shapes and offsets: equal hashes mean interchangeable vectors.
  uint64_t hash() const;

  // Fresh parameters; the same seed gives the same bits. `parameters` has size().
  void Initialize(uint64_t seed, std::span<float> parameters) const;

  // The name of the first tensor with a value that is not finite; empty when all are. `parameters` has
  // size().
  std::string_view FirstNonFinite(std::span<const float> parameters) const;

 private:
  std::vector<TensorInfo> tensors_;
  size_t size_ = 0;
};

// True when no value is infinite or NaN.
bool AllFinite(std::span<const float> values);

}  // namespace dadrl::nn
