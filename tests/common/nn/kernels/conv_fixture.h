// What the tests of the convolution stack share: random tensors, images, and the stack in double precision.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <new>
#include <ostream>
#include <random>
#include <vector>

#include "common/nn/kernels/conv_reference.h"
#include "common/nn/kernels/conv_stack.h"
#include "tests/common/util/isa_scope.h"

namespace dadrl::nn {

// How GoogleTest names the parameter.
inline void PrintTo(Isa isa, std::ostream* os) { *os << IsaName(isa); }

}  // namespace dadrl::nn

namespace dadrl::nn::testing {

inline std::vector<Isa> AvailableIsas() {
  std::vector<Isa> isas;
  for (int i = 0; i <= static_cast<int>(DetectIsa()); ++i) isas.push_back(static_cast<Isa>(i));
  return isas;
}

// 64-byte aligned memory, filled with NaN so that what a kernel reads before it writes shows.
class Arena {
 public:
  explicit Arena(size_t bytes)
      : floats_(bytes / sizeof(float)),
        memory_(static_cast<float*>(::operator new (bytes, std::align_val_t{64}))) {
    std::fill_n(memory_, floats_, std::nanf(""));
  }
  ~Arena() { ::operator delete (memory_, std::align_val_t{64}); }
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;
  void* get() { return memory_; }

 private:
  size_t floats_;
  float* memory_;
};

// Weights and biases of the five layers, or their gradients.
template <class Real>
struct Tensors {
  std::vector<Real> weight[kConvLayers];
  std::vector<Real> bias[kConvLayers];

  Tensors() {
    for (int l = 0; l < kConvLayers; ++l) {
      weight[l].resize(ConvStackWeightCount(l));
      bias[l].resize(ConvStackBiasCount(l));
    }
  }
  ConvStackParams params() const {
    ConvStackParams p;
    for (int l = 0; l < kConvLayers; ++l) p.weight[l] = weight[l].data(), p.bias[l] = bias[l].data();
    return p;
  }
  ConvStackGrads grads() {
    ConvStackGrads g;
    for (int l = 0; l < kConvLayers; ++l) g.weight[l] = weight[l].data(), g.bias[l] = bias[l].data();
    return g;
  }
  reference::Params<Real> reference_params() const {
    reference::Params<Real> p;
    for (int l = 0; l < kConvLayers; ++l) p.weight[l] = weight[l].data(), p.bias[l] = bias[l].data();
    return p;
  }
};

// He-scaled, so that signals neither vanish nor explode and about half of the outputs are active.
inline Tensors<float> RandomParams(unsigned seed) {
  std::mt19937 random(seed);
  Tensors<float> t;
  for (int l = 0; l < kConvLayers; ++l) {
    const float fan_in = static_cast<float>(t.weight[l].size() / t.bias[l].size());
    std::normal_distribution<float> weight(0.0F, std::sqrt(2.0F / fan_in)), bias(0.0F, 0.1F);
    for (float& w : t.weight[l]) w = weight(random);
    for (float& b : t.bias[l]) b = bias(random);
  }
  return t;
}

inline Tensors<double> ToDouble(const Tensors<float>& from) {
  Tensors<double> to;
  for (int l = 0; l < kConvLayers; ++l) {
    std::copy(from.weight[l].begin(), from.weight[l].end(), to.weight[l].begin());
    std::copy(from.bias[l].begin(), from.bias[l].end(), to.bias[l].begin());
  }
  return to;
}

inline std::vector<float> RandomFloats(size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  std::vector<float> values(count);
  for (float& v : values) v = normal(random);
  return values;
}

// Independent pixels; every third image is mostly empty, as the route plane is.
inline std::vector<uint8_t> RandomImages(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<uint8_t> bytes(static_cast<size_t>(count) * kContextImageBytes);
  for (size_t i = 0; i < bytes.size(); ++i) {
    const bool sparse = i / kContextImageBytes % 3 == 0;
    bytes[i] = sparse && random() % 16 != 0 ? 0 : static_cast<uint8_t>(random());
  }
  return bytes;
}

// A filled rectangle and a band across empty planes: whole blocks of pixels agree in all images.
inline std::vector<uint8_t> RoadImages(int count) {
  std::vector<uint8_t> bytes(static_cast<size_t>(count) * kContextImageBytes, 0);
  for (int n = 0; n < count; ++n) {
    uint8_t* const image = bytes.data() + static_cast<size_t>(n) * kContextImageBytes;
    for (int row = 10; row < 100; ++row) {
      for (int column = 50 + n % 7; column < 75; ++column) {
        image[row * 16 + column / 8] |= static_cast<uint8_t>(1U << (column % 8));
      }
      image[(128 + row) * 16 + (60 + row / 9) / 8] |= 0x1F;
    }
  }
  return bytes;
}

// Largest difference over the largest magnitude of expected.
template <class Actual, class Expected>
double MaxNormError(const Actual& actual, const Expected& expected) {
  double difference = 0, scale = 0;
  for (size_t i = 0; i < expected.size(); ++i) {
    const double error = std::abs(static_cast<double>(actual[i]) - static_cast<double>(expected[i]));
    if (!(error <= difference)) difference = error;  // NaN too
    scale = std::max(scale, std::abs(static_cast<double>(expected[i])));
  }
  return scale == 0 ? difference : difference / scale;
}

// Features of the batch and gradients of sum(d_features * features), all in double.
struct Oracle {
  std::vector<double> features;
  Tensors<double> grads;

  Oracle(const std::vector<uint8_t>& context, const Tensors<double>& params,
         const std::vector<float>& d_features) {
    const size_t batch = context.size() / kContextImageBytes;
    features.resize(batch * kConvFeatures);
    const auto image = std::make_unique<reference::Image<double>>();
    const auto out = std::make_unique<reference::Outputs<double>>();
    const auto d_out = std::make_unique<reference::Outputs<double>>();
    const auto sums = std::make_unique<reference::GradientSums>();
    const std::vector<double> d(d_features.begin(), d_features.end());
    for (size_t n = 0; n < batch; ++n) {
      const uint8_t* const one = context.data() + n * kContextImageBytes;
      reference::Forward(one, params.reference_params(), *image, *out);
      std::copy_n(out->layer5, kConvFeatures, features.begin() + static_cast<ptrdiff_t>(n * kConvFeatures));
      reference::Backward(one, params.reference_params(), *out, d.data() + n * kConvFeatures, *image, *d_out,
                          *sums);
    }
    const double* const weights[] = {sums->weight1, sums->weight2, sums->weight3, sums->weight4,
                                     sums->weight5};
    const double* const biases[] = {sums->bias1, sums->bias2, sums->bias3, sums->bias4, sums->bias5};
    for (int l = 0; l < kConvLayers; ++l) {
      std::copy_n(weights[l], grads.weight[l].size(), grads.weight[l].begin());
      std::copy_n(biases[l], grads.bias[l].size(), grads.bias[l].begin());
    }
  }
};

// [batch][256] as the kernels take it, [batch / 16][256][16], and back.
inline std::vector<float> ToLanes(const std::vector<float>& rows) {
  std::vector<float> lanes(rows.size());
  for (size_t i = 0; i < rows.size(); ++i) {
    const size_t n = i / kConvFeatures;
    lanes[(n / kLanes * kConvFeatures + i % kConvFeatures) * kLanes + n % kLanes] = rows[i];
  }
  return lanes;
}
inline std::vector<float> ToRows(const std::vector<float>& lanes) {
  std::vector<float> rows(lanes.size());
  for (size_t i = 0; i < rows.size(); ++i) {
    const size_t n = i / kConvFeatures;
    rows[i] = lanes[(n / kLanes * kConvFeatures + i % kConvFeatures) * kLanes + n % kLanes];
  }
  return rows;
}

// The same with the kernels in use.
struct StepResult {
  std::vector<float> features;
  Tensors<float> grads;

  StepResult(const std::vector<uint8_t>& context, const Tensors<float>& params,
             const std::vector<float>& d_features) {
    const int batch = static_cast<int>(context.size() / kContextImageBytes);
    features.resize(static_cast<size_t>(batch) * kConvFeatures);
    Arena arena(ConvStackActivationBytes(batch, true));
    ConvStackForward(context.data(), batch, params.params(), arena.get(), features.data(), true);
    features = ToRows(features);
    ConvStackBackward(context.data(), batch, params.params(), arena.get(), ToLanes(d_features).data(),
                      grads.grads());
  }
};

}  // namespace dadrl::nn::testing
