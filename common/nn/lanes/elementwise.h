// Transposition, activations, layer norm and the optimiser. Internal to the kernel translation units.
#pragma once

#include "common/nn/lanes/lane_kernels.h"
#include "common/nn/lanes/vector.h"

namespace dadrl::nn {
namespace {

void ToRows(const float* lanes, int features, float* rows, ptrdiff_t row_stride) {
  for (int first = 0; first < features; first += kWidth) {
    const int count = features - first < kWidth ? features - first : kWidth;
    Lanes v[kWidth];
    for (int i = 0; i < kWidth; ++i) v[i] = i < count ? Load(lanes + (first + i) * kWidth) : Lanes{};
    Transpose(v);
    for (int i = 0; i < kWidth; ++i) Store(rows + i * row_stride + first, v[i]);
  }
}

void ToLanes(const float* rows, ptrdiff_t row_stride, int count, int features, float* lanes) {
  for (int first = 0; first < features; first += kWidth) {
    const int width = features - first < kWidth ? features - first : kWidth;
    Lanes v[kWidth];
    for (int i = 0; i < kWidth; ++i)
      v[i] = i < count ? LoadPart(rows + i * row_stride + first, width) : Lanes{};
    Transpose(v);
    for (int i = 0; i < width; ++i) Store(lanes + (first + i) * kWidth, v[i]);
  }
}

void ReluForward(const float* input, float* output, size_t count) {
  for (size_t i = 0; i < count; i += kWidth) Store(output + i, Relu(Load(input + i)));
}

void ReluBackward(const float* output, float* gradient, size_t count) {
  for (size_t i = 0; i < count; i += kWidth) {
    Store(gradient + i, Load(output + i) > 0.0f ? Load(gradient + i) : Lanes{});
  }
}

void SumSamples(const float* gradient, ptrdiff_t block_stride, int blocks, int features, float* sums) {
  for (int first = 0; first < features; first += kWidth) {
    const int count = features - first < kWidth ? features - first : kWidth;
    Lanes v[kWidth] = {};
    for (int block = 0; block < blocks; ++block) {
      const float* from = gradient + block * block_stride + first * kWidth;
      for (int i = 0; i < count; ++i) v[i] += Load(from + i * kWidth);
    }
    Transpose(v);
    Lanes total = v[0];
    for (int i = 1; i < kWidth; ++i) total += v[i];
    StorePart(sums + first, total + LoadPart(sums + first, count), count);
  }
}

void LayerNormForward(const float* input, int features, float* normalized, float* inverse_deviation) {
  const float scale = 1.0f / static_cast<float>(features);
  Lanes sum = {};
  for (int i = 0; i < features; ++i) sum += Load(input + i * kWidth);
  const Lanes mean = sum * scale;
  Lanes squares = {};
  for (int i = 0; i < features; ++i) {
    const Lanes d = Load(input + i * kWidth) - mean;
    squares += d * d;
  }
  const Lanes inverse = 1.0f / Sqrt(squares * scale + kLayerNormEpsilon);
  for (int i = 0; i < features; ++i) {
    Store(normalized + i * kWidth, (Load(input + i * kWidth) - mean) * inverse);
  }
  Store(inverse_deviation, inverse);
}

void LayerNormBackward(const float* normalized, const float* inverse_deviation, int features,
                       float* gradient) {
  const float scale = 1.0f / static_cast<float>(features);
  Lanes sum = {};
  Lanes projected = {};
  for (int i = 0; i < features; ++i) {
    const Lanes g = Load(gradient + i * kWidth);
    sum += g;
    projected += g * Load(normalized + i * kWidth);
  }
  const Lanes mean = sum * scale;
  const Lanes slope = projected * scale;
  const Lanes inverse = Load(inverse_deviation);
  for (int i = 0; i < features; ++i) {
    const Lanes g = Load(gradient + i * kWidth);
    Store(gradient + i * kWidth, inverse * (g - mean - slope * Load(normalized + i * kWidth)));
  }
}

bool Adam(const AdamRange& r) {
  Lanes poison = {};
  for (size_t i = 0; i < r.count; i += kWidth) {
    Lanes g = Load(r.gradients[0] + i);
    Store(r.gradients[0] + i, Lanes{});
    for (int t = 1; t < r.threads; ++t) {
      g += Load(r.gradients[t] + i);
      Store(r.gradients[t] + i, Lanes{});
    }
    const Lanes m = r.beta1 * Load(r.first_moment + i) + (1.0f - r.beta1) * g;
    const Lanes v = r.beta2 * Load(r.second_moment + i) + (1.0f - r.beta2) * g * g;
    Store(r.first_moment + i, m);
    Store(r.second_moment + i, v);
    const Lanes p =
        Load(r.parameters + i) - r.step_size * m / (Sqrt(v) * r.inverse_root_correction + r.epsilon);
    Store(r.parameters + i, p);
    poison += p * 0.0f;  // zero, or NaN for good once a parameter is not finite
    if (r.target != nullptr) {
      const Lanes target = Load(r.target + i);
      Store(r.target + i, target + r.tau * (p - target));
    }
  }
  float sum = 0.0f;
  for (int i = 0; i < kWidth; ++i) sum += poison[i];
  return sum == 0.0f;
}

void Average(const float* parameters, float* average, size_t count, float decay) {
  for (size_t i = 0; i < count; i += kWidth) {
    const Lanes old = Load(average + i);
    Store(average + i, old + (1.0f - decay) * (Load(parameters + i) - old));
  }
}

}  // namespace
}  // namespace dadrl::nn
