// Compiled once per instruction set; DADRL_LANE_TABLE names the one symbol that leaves each.
#include "common/nn/lanes/elementwise.h"
#include "common/nn/lanes/product.h"
#include "common/nn/lanes/recurrent.h"

namespace dadrl::nn {

extern const LaneKernels DADRL_LANE_TABLE;
const LaneKernels DADRL_LANE_TABLE = {
    .multiply = Multiply,
    .to_rows = ToRows,
    .to_lanes = ToLanes,
    .lstm_forward = LstmForward,
    .lstm_backward = LstmBackward,
    .attention_forward = AttentionForward,
    .attention_backward = AttentionBackward,
    .relu_backward = ReluBackward,
    .sum_samples = SumSamples,
    .layer_norm_forward = LayerNormForward,
    .layer_norm_backward = LayerNormBackward,
    .relu = ReluForward,
    .adam = Adam,
    .average = Average,
};

}  // namespace dadrl::nn
