// Transposition, activations, layer norm and the optimiser. Internal to the kernel translation units.
#pragma once

#include "common/nn/lanes/lane_kernels.h"
#include "common/nn/lanes/vector.h"

namespace dadrl::nn {
namespace {

void ToRows(const float* lanes, int features, float* rows, ptrdiff_t row_stride) {
  for (int first = 0; first < features; first += kLanes) {
    const int count = features - first < kLanes ? features - first : kLanes;
    Lanes v[kLanes];
    for (int i = 0; i < kLanes; ++i) v[i] = i < count ? Load(lanes + (first + i) * kLanes) : Lanes{};
    Transpose(v);
    for (int i = 0; i < kLanes; ++i) Store(rows + i * row_stride + first, v[i]);
  }
}

void ToLanes(const float* rows, ptrdiff_t row_stride, int count, int features, float* lanes) {
  for (int first = 0; first < features; first += kLanes) {
    const int width = features - first < kLanes ? features - first : kLanes;
    Lanes v[kLanes];
    for (int i = 0; i < kLanes; ++i)
      v[i] = i < count ? LoadPart(rows + i * row_stride + first, width) : Lanes{};
    Transpose(v);
    for (int i = 0; i < width; ++i) Store(lanes + (first + i) * kLanes, v[i]);
  }
}

void ReluForward(const float* input, float* output, size_t count) {
  for (size_t i = 0; i < count; i += kLanes) Store(output + i, Relu(Load(input + i)));
}

void ReluBackward(const float* output, float* gradient, size_t count) {
  for (size_t i = 0; i < count; i += kLanes) {
    Store(gradient + i, Load(output + i) > 0.0f ? Load(gradient + i) : Lanes{});
  }
}

void SumSamples(const float* gradient, ptrdiff_t block_stride, int blocks, int features, float* sums) {
  for (int first = 0; first < features; first += kLanes) {
    const int count = features - first < kLanes ? features - first : kLanes;
    Lanes v[kLanes] = {};
    for (int block = 0; block < blocks; ++block) {
      const float* from = gradient + block * block_stride + first * kLanes;
      for (int i = 0; i < count; ++i) v[i] += Load(from + i * kLanes);
    }
    Transpose(v);
    Lanes total = v[0];
    for (int i = 1; i < kLanes; ++i) total += v[i];
    StorePart(sums + first, total + LoadPart(sums + first, count), count);
  }
}

void LayerNormForward(const float* input, int features, float* normalized, float* inverse_deviation) {
  const float scale = 1.0f / features;
  Lanes sum = {};
  for (int i = 0; i < features; ++i) sum += Load(input + i * kLanes);
  const Lanes mean = sum * scale;
  Lanes squares = {};
  for (int i = 0; i < features; ++i) {
    const Lanes d = Load(input + i * kLanes) - mean;
    squares += d * d;
  }
  const Lanes inverse = 1.0f / Sqrt(squares * scale + kLayerNormEpsilon);
  for (int i = 0; i < features; ++i) {
    Store(normalized + i * kLanes, (Load(input + i * kLanes) - mean) * inverse);
  }
  Store(inverse_deviation, inverse);
}

void LayerNormBackward(const float* normalized, const float* inverse_deviation, int features,
                       float* gradient) {
  const float scale = 1.0f / features;
  Lanes sum = {};
  Lanes projected = {};
  for (int i = 0; i < features; ++i) {
    const Lanes g = Load(gradient + i * kLanes);
    sum += g;
    projected += g * Load(normalized + i * kLanes);
  }
  const Lanes mean = sum * scale;
  const Lanes slope = projected * scale;
  const Lanes inverse = Load(inverse_deviation);
  for (int i = 0; i < features; ++i) {
    const Lanes g = Load(gradient + i * kLanes);
    Store(gradient + i * kLanes, inverse * (g - mean - slope * Load(normalized + i * kLanes)));
  }
}

bool Adam(const AdamRange& r) {
  Lanes poison = {};
  for (size_t i = 0; i < r.count; i += kLanes) {
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
  for (int i = 0; i < kLanes; ++i) sum += poison[i];
  return sum == 0.0f;
}

void Average(const float* parameters, float* average, size_t count, float decay) {
  for (size_t i = 0; i < count; i += kLanes) {
    const Lanes old = Load(average + i);
    Store(average + i, old + (1.0f - decay) * (Load(parameters + i) - old));
  }
}

}  // namespace
}  // namespace dadrl::nn
