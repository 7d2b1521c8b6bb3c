// The arithmetic that the networks need, in multiply-adds a sample: true taps, no padding, default sizes.
#pragma once

#include "common/config/config.h"
#include "common/nn/kernels/conv_shapes.h"

namespace dadrl::bench {

struct NetworkWork {
  template <class Shape>
  static constexpr double kConv = double{Shape::kWeights} * Shape::kOutSize* Shape::kOutSize;
  static constexpr double kConv1 = kConv<nn::PaperConv1>;
  static constexpr double kConvs =
      kConv1 + kConv<nn::PaperConv2> + kConv<nn::Conv3> + kConv<nn::Conv4> + kConv<nn::Conv5>;
  static constexpr double kContextOutput = double{nn::kConvFeatures} * 128;
  // Seven sequences of five steps; the first has no state to multiply.
  static constexpr double kLstmInput = 7.0 * 5 * 7 * 224;
  static constexpr double kLstmState = 7.0 * 4 * 56 * 224;
  // Four products of 56 x 56 and, for six vehicles, scores and weighted sum.
  static constexpr double kAttention = 4.0 * 56 * 56 + 2 * 6.0 * 56;
  static constexpr double kStaeOutput = 76.0 * 128;

  static constexpr double kEncoderForward =
      kConvs + kContextOutput + kLstmInput + kLstmState + kAttention + kStaeOutput;
  // Inputs and weights; no gradient for image and histories, nor for the ego's row in the last layer.
  static constexpr double kEncoderBackward = 2 * kConvs - kConv1 + 2 * kContextOutput + kLstmInput +
                                             2 * kLstmState + 2 * kAttention + kStaeOutput + 56.0 * 128;
  static constexpr double kPolicy = 256.0 * 256 + 256 * 256 + 256 * 4;
  static constexpr double kCritics = 2 * (258.0 * 256 + 256 * 256 + 256);

  // FLOP of acting on one observation.
  static constexpr double kActFlops = 2 * (kEncoderForward + kPolicy);
  // FLOP of one update, a sample. Separate encoders: five forward passes, two backward; shared: three and
  // one.
  static constexpr double UpdateFlops(EncoderSharing encoders) {
    const bool shared = encoders == EncoderSharing::kShared;
    const double encoder = (shared ? 3 : 5) * kEncoderForward + (shared ? 1 : 2) * kEncoderBackward;
    return 2 * (encoder + 4 * kPolicy + 6 * kCritics);
  }
};

}  // namespace dadrl::bench
