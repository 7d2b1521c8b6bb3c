// The spatio-temporal attention encoder for a single observation.
#pragma once

#include <vector>

#include "common/model/dense_row.h"
#include "common/model/stae.h"

namespace dadrl {

// Same function as StaeForward. Vehicles whose newest row is absent get no attention, so their histories are
// not even read. Arena memory; not thread safe.
class ActingStae {
 public:
  ActingStae(nn::Arena& arena, const DrivingShape& spec);

  void Pack(const Stae& stae, const float* parameters);
  // features [128]; attention [vehicles], zero for the absent.
  void Forward(const nn::LaneKernels& kernels, const Observation& observation, float* features,
               std::vector<float>& attention);

 private:
  void Encode(const nn::LaneKernels& kernels, const Observation& observation);
  void Attend(const nn::LaneKernels& kernels, std::vector<float>& attention);

  DrivingShape spec_;
  int sequences_ = 0;           // of this observation: the ego and the present vehicles
  std::vector<int> present_;    // their vehicle indices
  float* recurrent_ = nullptr;  // [56 hidden + 7 inputs][4 gates of 64]
  float* gate_bias_ = nullptr;  // [4 gates of 64]
  float* key_bias_ = nullptr;
  float* value_bias_ = nullptr;
  DenseRow query_, key_, value_, output_, joined_output_;
  float* joined_input_ = nullptr;  // [sequences][56 + 7, padded]
  float* gates_ = nullptr;         // [sequences][4][64]
  float* cell_ = nullptr;          // [sequences][64]
  float* cell_tanh_ = nullptr;     // [64]
  float* hidden_ = nullptr;        // [sequences][64]
  float* row_[4] = {};             // scratch vectors
  float* joined_ = nullptr;        // [20 + 56]
};

}  // namespace dadrl
