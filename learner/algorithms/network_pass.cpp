#include "learner/algorithms/network_pass.h"

namespace dadrl {

NetworkPass::NetworkPass(nn::Arena& arena, const Encoder& encoder_of, const Mlp& head_of, size_t parameters,
                         int blocks)
    : encoder(arena, encoder_of, blocks, true),
      encoder_scratch(arena, encoder_of, blocks),
      head(arena, head_of, blocks),
      head_scratch(arena, head_of, blocks),
      features(nn::TakeLanes(arena, encoder_of.features(), blocks)),
      feature_gradient(nn::TakeLanes(arena, encoder_of.features(), blocks)),
      output(nn::TakeLanes(arena, head_of.output.outputs, blocks)),
      output_gradient(nn::TakeLanes(arena, head_of.output.outputs, blocks)),
      gradient(arena.Allocate(parameters)) {}

void ForwardPass(const nn::LaneKernels& kernels, const Encoder& encoder, const Mlp& head,
                 const float* parameters, const LaneObservations& observations, const NetworkPass& pass) {
  EncoderForward(kernels, encoder, parameters, observations, pass.encoder, pass.features);
  MlpForward(kernels, head, parameters, pass.features, observations.blocks, pass.head, pass.output);
}

void BackwardPass(const nn::LaneKernels& kernels, const Encoder& encoder, const Mlp& head,
                  const float* parameters, const LaneObservations& observations, const NetworkPass& pass) {
  MlpBackward(
      kernels, head, parameters, pass.features, observations.blocks, pass.head, pass.output_gradient,
      {.parameters = pass.gradient, .input = pass.feature_gradient, .input_count = encoder.features()},
      pass.head_scratch);
  EncoderBackward(kernels, encoder, parameters, pass.gradient, observations, pass.encoder, pass.features,
                  pass.feature_gradient, pass.encoder_scratch);
}

}  // namespace dadrl
