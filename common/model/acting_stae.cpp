#include "common/model/acting_stae.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace dadrl {

using nn::kLanes;

namespace {

constexpr int kUnits = Stae::kUnits;
constexpr int kPadded = 64;  // units in whole vectors; the padding's state stays zero
constexpr int kGates = 4 * kPadded;
constexpr int kInputs = DrivingShape::kVehicleFeatures;
constexpr int kEgo = DrivingShape::kEgoFeatures;
constexpr int kRows = 4;  // sequences are processed in multiples of this, which the product's tiles like

float Dot(const float* a, const float* b) {
  float sum = 0.0f;
  for (int i = 0; i < kUnits; ++i) sum += a[i] * b[i];
  return sum;
}

void LayerNorm(const float* input, float* output) {
  float mean = 0.0f;
  for (int i = 0; i < kUnits; ++i) mean += input[i];
  mean /= kUnits;
  float variance = 0.0f;
  for (int i = 0; i < kUnits; ++i) variance += (input[i] - mean) * (input[i] - mean);
  const float inverse = 1.0f / std::sqrt(variance / kUnits + nn::kLayerNormEpsilon);
  for (int i = 0; i < kUnits; ++i) output[i] = (input[i] - mean) * inverse;
}

}  // namespace

ActingStae::ActingStae(nn::Arena& arena, const DrivingShape& spec)
    : spec_(spec),
      recurrent_(arena.Allocate(size_t{kUnits + kInputs} * kGates)),
      gate_bias_(arena.Allocate(kGates)),
      key_bias_(arena.Allocate(kUnits)),
      value_bias_(arena.Allocate(kUnits)),
      query_(arena, kUnits, kUnits),
      key_(arena, kUnits, kUnits),
      value_(arena, kUnits, kUnits),
      output_(arena, kUnits, kUnits),
      joined_output_(arena, kEgo + kUnits, Stae::kFeatures) {
  const auto vehicles = static_cast<size_t>(spec.vehicles);
  present_.reserve(vehicles);
  const size_t rows = nn::RoundUp(1 + vehicles, kRows);
  joined_input_ = arena.Allocate(rows * kPadded);
  gates_ = arena.Allocate(rows * kGates);
  cell_ = arena.Allocate(rows * kPadded);
  cell_tanh_ = arena.Allocate(kPadded);
  hidden_ = arena.Allocate(rows * kPadded);
  for (float*& row : row_) row = arena.Allocate(kPadded);
  joined_ = arena.Allocate(kEgo + kUnits);
}

void ActingStae::Pack(const Stae& stae, const float* parameters) {
  const float* const hidden_weights = parameters + stae.lstm.weight_hh;
  const float* const input_weights = parameters + stae.lstm.weight_ih;
  const float* const bias = parameters + stae.lstm.bias;
  for (int gate = 0; gate < 4; ++gate) {
    for (int j = 0; j < kUnits; ++j) {
      const int from = gate * kUnits + j;
      const int to = gate * kPadded + j;
      for (int k = 0; k < kUnits; ++k) {
        recurrent_[k * kGates + to] = hidden_weights[from * kUnits + k];
      }
      for (int k = 0; k < kInputs; ++k) {
        recurrent_[(kUnits + k) * kGates + to] = input_weights[from * kInputs + k];
      }
      gate_bias_[to] = bias[from];
    }
  }
  const nn::Attention& attention = stae.attention;
  query_.Pack(parameters + attention.query.weight, parameters + attention.query.bias);
  key_.PackTransposed(parameters + attention.key.weight);
  value_.Pack(parameters + attention.value.weight, nullptr);
  output_.Pack(parameters + attention.output.weight, parameters + attention.output.bias);
  joined_output_.Pack(parameters + stae.output.weight, parameters + stae.output.bias);
  std::memcpy(key_bias_, parameters + attention.key.bias, kUnits * sizeof(float));
  std::memcpy(value_bias_, parameters + attention.value.bias, kUnits * sizeof(float));
}

void ActingStae::Forward(const nn::LaneKernels& kernels, const Observation& observation, float* features,
                         std::vector<float>& attention) {
  Encode(kernels, observation);
  Attend(kernels, attention);
  std::memcpy(joined_, observation.floats(spec_.ego_column).data() + (spec_.history - 1) * kEgo,
              kEgo * sizeof(float));
  joined_output_.Apply(kernels, joined_, features, true);
}

// hidden_ [sequences][64]: the last states of the ego and of the present vehicles.
void ActingStae::Encode(const nn::LaneKernels& kernels, const Observation& observation) {
  const int vehicle = spec_.history * kInputs;
  const float* const vehicles = observation.floats(spec_.vehicles_column).data();
  const float* const ego = observation.floats(spec_.ego_column).data();
  present_.clear();
  for (int v = 0; v < spec_.vehicles; ++v) {
    const float absent = vehicles[(v + 1) * vehicle - kInputs];
    if (!(absent > 0.5f)) present_.push_back(v);
  }
  sequences_ = 1 + std::ssize(present_);
  const int rows = (sequences_ + kRows - 1) / kRows * kRows;
  for (int t = 0; t < spec_.history; ++t) {
    for (int s = 0; s < rows; ++s) {
      std::memcpy(gates_ + s * kGates, gate_bias_, kGates * sizeof(float));
      if (s >= sequences_) continue;
      const float* input =
          s == 0 ? ego + t * kEgo : vehicles + present_.data()[s - 1] * vehicle + t * kInputs;
      float* joined = joined_input_ + s * kPadded;
      if (t > 0) std::memcpy(joined, hidden_ + s * kPadded, kUnits * sizeof(float));
      std::memcpy(joined + kUnits, input, kInputs * sizeof(float));
    }
    const int skip = t == 0 ? kUnits : 0;  // the state starts at zero
    kernels.multiply({.rows = rows,
                      .blocks = kGates / kLanes,
                      .depth = kUnits + kInputs - skip,
                      .a = joined_input_ + skip,
                      .a_row = kPadded,
                      .a_depth = 1,
                      .b = recurrent_ + ptrdiff_t{skip} * kGates,
                      .b_block = kLanes,
                      .b_depth = kGates,
                      .c = gates_,
                      .c_block = kLanes,
                      .c_row = kGates,
                      .accumulate = true});
    for (int s = 0; s < sequences_; ++s) {
      kernels.lstm_forward({.units = kPadded / kLanes,
                            .gates = gates_ + s * kGates,
                            .previous_cell = t == 0 ? nullptr : cell_ + s * kPadded,
                            .cell = cell_ + s * kPadded,
                            .cell_tanh = cell_tanh_,
                            .hidden = hidden_ + s * kPadded});
    }
  }
}

// joined_'s last 56: the normalised sum of the ego's state and what it attends to.
void ActingStae::Attend(const nn::LaneKernels& kernels, std::vector<float>& attention) {
  float* query = row_[0];
  float* folded = row_[1];
  float* context = row_[2];
  float* value = row_[3];
  std::fill(attention.begin(), attention.end(), 0.0f);
  query_.Apply(kernels, hidden_, query, false);
  key_.Apply(kernels, query, folded, false);
  const float bias = Dot(query, key_bias_);
  const float scale = 1.0f / std::sqrt(static_cast<float>(kUnits));
  float highest = 0.0f;  // the zero slot's score
  for (size_t i = 0; i < present_.size(); ++i) {
    float& score = attention.data()[present_[i]];
    score = (Dot(folded, hidden_ + (i + 1) * kPadded) + bias) * scale;
    highest = std::max(highest, score);
  }
  float sum = std::exp(-highest);
  for (const int v : present_) {
    float& weight = attention.data()[v];
    weight = std::exp(weight - highest);
    sum += weight;
  }
  float total = 0.0f;
  std::fill(context, context + kPadded, 0.0f);
  for (size_t i = 0; i < present_.size(); ++i) {
    float& weight = attention.data()[present_[i]];
    weight /= sum;
    total += weight;
    const float* const hidden = hidden_ + (i + 1) * kPadded;
    for (int j = 0; j < kUnits; ++j) context[j] += weight * hidden[j];
  }
  value_.Apply(kernels, context, value, false);
  for (int j = 0; j < kUnits; ++j) value[j] += total * value_bias_[j];
  output_.Apply(kernels, value, context, false);
  for (int j = 0; j < kUnits; ++j) context[j] += hidden_[j];
  LayerNorm(context, joined_ + kEgo);
}

}  // namespace dadrl
