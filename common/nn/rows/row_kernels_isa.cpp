// Compiled once per instruction set; DADRL_ROW_TABLE names the one symbol that leaves each.
#include "common/nn/lanes/lane_kernels.h"
#include "common/nn/lanes/vector.h"
#include "common/nn/rows/row_kernels.h"

namespace dadrl::nn {
namespace {

DADRL_INLINE float Sum(const Lanes& x) {
  float sum = 0.0f;
  for (int i = 0; i < kLanes; ++i) sum += x[i];
  return sum;
}

// 1 for the first `count` of sixteen, else 0.
DADRL_INLINE Lanes FirstOf(int count) {
  Lanes mask;
  for (int i = 0; i < kLanes; ++i) mask[i] = i < count ? 1.0f : 0.0f;
  return mask;
}

constexpr float kLowest = -1e30f;

DADRL_INLINE bool Sees(const ScoreRows& s, int query, int key) {
  if (s.causal && key > query) return false;
  return s.absent == nullptr || s.absent[key * s.absent_stride] < 0.5f;
}

void SoftmaxForward(const ScoreRows& s) {
  for (int query = 0; query < s.queries; ++query) {
    float* const row = s.scores + query * s.stride;
    float highest = kLowest;
    for (int key = 0; key < s.keys; ++key) {
      row[key] = Sees(s, query, key) ? row[key] * s.scale : kLowest;
      highest = row[key] > highest ? row[key] : highest;
    }
    Lanes sum = {};
    for (int first = 0; first < s.keys; first += kLanes) {
      const Lanes score = Load(row + first);
      Lanes weight = Exp(score - highest);
      weight = score <= 0.5f * kLowest ? Lanes{} : weight;  // NaN stays NaN
      weight *= FirstOf(s.keys - first);
      sum += weight;
      Store(row + first, weight);
    }
    const float total = Sum(sum);
    const Lanes inverse = Splat(total == 0.0f ? 0.0f : 1.0f / total);
    for (int first = 0; first < s.keys; first += kLanes) Store(row + first, Load(row + first) * inverse);
  }
}

void SoftmaxBackward(const ScoreRows& s) {
  for (int query = 0; query < s.queries; ++query) {
    float* const row = s.scores + query * s.stride;
    const float* const weights = s.weights + query * s.stride;
    Lanes projected = {};
    for (int first = 0; first < s.keys; first += kLanes) {
      projected += Load(row + first) * Load(weights + first);
    }
    const Lanes mean = Splat(Sum(projected));
    for (int first = 0; first < s.keys; first += kLanes) {
      Store(row + first, s.scale * Load(weights + first) * (Load(row + first) - mean));
    }
  }
}

void LayerNormForward(const NormRows& s) {
  const float scale = 1.0f / static_cast<float>(s.features);
  for (int r = 0; r < s.rows; ++r) {
    const float* const in = s.input + r * s.stride;
    float* const normalized = s.normalized + r * s.stride;
    Lanes sum = {};
    for (int f = 0; f < s.features; f += kLanes) sum += Load(in + f);
    const Lanes mean = Splat(Sum(sum) * scale);
    Lanes squares = {};
    for (int f = 0; f < s.features; f += kLanes) {
      const Lanes d = (Load(in + f) - mean) * FirstOf(s.features - f);
      squares += d * d;
    }
    const float inverse = 1.0f / __builtin_sqrtf(Sum(squares) * scale + kLayerNormEpsilon);
    s.inverse_deviation[r] = inverse;
    for (int f = 0; f < s.features; f += kLanes) {
      const Lanes n = (Load(in + f) - mean) * inverse * FirstOf(s.features - f);
      Store(normalized + f, n);
      Store(s.output + r * s.stride + f, n + n * Load(s.gain + f) + Load(s.bias + f));
    }
  }
}

void LayerNormBackward(const NormRows& s) {
  const float scale = 1.0f / static_cast<float>(s.features);
  for (int r = 0; r < s.rows; ++r) {
    const float* const out = s.output_gradient + r * s.stride;
    const float* const normalized = s.normalized + r * s.stride;
    Lanes sum = {};
    Lanes projected = {};
    for (int f = 0; f < s.features; f += kLanes) {
      const Lanes dy = Load(out + f);
      const Lanes n = Load(normalized + f);
      const Lanes g = dy + dy * Load(s.gain + f);
      sum += g;
      projected += g * n;
      Store(s.gain_gradient + f, Load(s.gain_gradient + f) + dy * n);
      Store(s.bias_gradient + f, Load(s.bias_gradient + f) + dy);
    }
    if (s.input_gradient == nullptr) continue;
    const Lanes mean = Splat(Sum(sum) * scale);
    const Lanes slope = Splat(Sum(projected) * scale);
    float* const in = s.input_gradient + r * s.stride;
    for (int f = 0; f < s.features; f += kLanes) {
      const Lanes dy = Load(out + f);
      const Lanes g = dy + dy * Load(s.gain + f) - mean - slope * Load(normalized + f);
      Store(in + f, Load(in + f) + s.inverse_deviation[r] * g * FirstOf(s.features - f));
    }
  }
}

void TanhForward(const float* input, float* output, size_t count) {
  for (size_t i = 0; i < count; i += kLanes) Store(output + i, Tanh(Load(input + i)));
}

void TanhBackward(const float* output, const float* output_gradient, float* input_gradient, size_t count) {
  for (size_t i = 0; i < count; i += kLanes) {
    const Lanes y = Load(output + i);
    Store(input_gradient + i, Load(input_gradient + i) + Load(output_gradient + i) * (1.0f - y * y));
  }
}

void ReluBackward(const float* output, const float* output_gradient, float* input_gradient, size_t count) {
  for (size_t i = 0; i < count; i += kLanes) {
    const Lanes passed = Load(output + i) > 0.0f ? Load(output_gradient + i) : Lanes{};
    Store(input_gradient + i, Load(input_gradient + i) + passed);
  }
}

void Add(const float* addend, float* sum, size_t count) {
  for (size_t i = 0; i < count; i += kLanes) Store(sum + i, Load(sum + i) + Load(addend + i));
}

void SumRows(const float* rows, int count, ptrdiff_t stride, float* sums) {
  for (ptrdiff_t f = 0; f < stride; f += kLanes) {
    Lanes even = {};
    Lanes odd = {};
    for (int r = 0; r < count; ++r) {
      (r % 2 == 0 ? even : odd) += Load(rows + r * stride + f);
    }
    Store(sums + f, Load(sums + f) + (even + odd));
  }
}

}  // namespace

extern const RowKernels DADRL_ROW_TABLE;
const RowKernels DADRL_ROW_TABLE = {
    .softmax_forward = SoftmaxForward,
    .softmax_backward = SoftmaxBackward,
    .layer_norm_forward = LayerNormForward,
    .layer_norm_backward = LayerNormBackward,
    .tanh = TanhForward,
    .tanh_backward = TanhBackward,
    .relu_backward = ReluBackward,
    .add = Add,
    .sum_rows = SumRows,
};

}  // namespace dadrl::nn
