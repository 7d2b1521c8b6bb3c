// An encoder and its head on one thread's share of a batch, there and back: what a method with one output a
// network is made of.
#pragma once

#include "common/model/encoder.h"
#include "common/model/mlp.h"

namespace dadrl {

// The memory of it, laid out in an arena.
struct NetworkPass {
  // `parameters`: of the network's layout.
  NetworkPass(nn::Arena& arena, const Encoder& encoder, const Mlp& head, size_t parameters, int blocks);

  EncoderActivations encoder;
  EncoderScratch encoder_scratch;
  MlpActivations head;
  MlpScratch head_scratch;
  nn::LaneSpan features, feature_gradient;  // [blocks][features][16]
  nn::LaneSpan output, output_gradient;     // [blocks][outputs][16]
  float* gradient = nullptr;                // [parameters], zeroed by the optimiser's step
};

void ForwardPass(const nn::LaneKernels& kernels, const Encoder& encoder, const Mlp& head,
                 const float* parameters, const LaneObservations& observations, const NetworkPass& pass);

// Adds to pass.gradient what follows from pass.output_gradient, after the forward pass of the same batch.
void BackwardPass(const nn::LaneKernels& kernels, const Encoder& encoder, const Mlp& head,
                  const float* parameters, const LaneObservations& observations, const NetworkPass& pass);

}  // namespace dadrl
