// The convolution stack as plain loops, one image at a time: the portable implementation (isa.h, kScalar) and
// what the tests hold the vector kernels against. Real is the type of the tensors; sums are in double.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "common/nn/kernels/conv_shapes.h"

namespace dadrl::nn::reference {

template <class Real>
struct Params {
  const Real* weight[kConvLayers];
  const Real* bias[kConvLayers];
};

// Outputs of every layer after the ReLU, or their gradients, for one image.
template <class Real>
struct Outputs {
  Real layer1[PaperConv1::kOutElements];
  Real layer2[PaperConv2::kOutElements];
  Real layer3[Conv3::kOutElements];
  Real layer4[Conv4::kOutElements];
  Real layer5[Conv5::kOutElements];
};

// Sums over the images of a batch.
struct GradientSums {
  double weight1[PaperConv1::kWeights], weight2[PaperConv2::kWeights], weight3[Conv3::kWeights];
  double weight4[Conv4::kWeights], weight5[Conv5::kWeights];
  double bias1[PaperConv1::kOut], bias2[PaperConv2::kOut], bias3[Conv3::kOut], bias4[Conv4::kOut];
  double bias5[Conv5::kOut];
};

template <class Real>
struct Image {
  Real pixel[kContextPlanes * kContextSide * kContextSide];
};

// context: [4096] bytes, the first bit of a byte is its lowest.
template <class Real>
void Unpack(const uint8_t* context, Image<Real>& image) {
  for (int i = 0; i < kContextPlanes * kContextSide * kContextSide; ++i) {
    image.pixel[i] = static_cast<Real>((context[i / 8] >> (i % 8)) & 1);
  }
}

template <class Shape, class Real>
void ForwardLayer(const Real* in, const Real* weight, const Real* bias, Real* out) {
  constexpr int kSize = Shape::kInSize, kOutSize = Shape::kOutSize, kKernel = Shape::kKernel;
  for (int co = 0; co < Shape::kOut; ++co) {
    for (int y = 0; y < kOutSize; ++y) {
      for (int x = 0; x < kOutSize; ++x) {
        double sum = bias[co];
        for (int ci = 0; ci < Shape::kIn; ++ci) {
          const Real* const w = weight + (co * Shape::kIn + ci) * Shape::kTaps;
          const Real* const window = in + (ci * kSize + 2 * y) * kSize + 2 * x;
          for (int ky = 0; ky < kKernel; ++ky) {
            for (int kx = 0; kx < kKernel; ++kx) {
              sum += double{w[ky * kKernel + kx]} * double{window[ky * kSize + kx]};
            }
          }
        }
        out[(co * kOutSize + y) * kOutSize + x] = static_cast<Real>(sum < 0 ? 0 : sum);
      }
    }
  }
}

// d_out: gradient of the sums before the ReLU. Adds to d_weight and d_bias; d_in, if any, is overwritten by
// the gradient before the previous layer's ReLU, whose output is in.
template <class Shape, class Real>
void BackwardLayer(const Real* in, const Real* weight, const Real* d_out, double* d_weight, double* d_bias,
                   Real* d_in) {
  constexpr int kSize = Shape::kInSize, kOutSize = Shape::kOutSize, kKernel = Shape::kKernel;
  if (d_in != nullptr) std::memset(d_in, 0, sizeof(Real) * Shape::kIn * kSize * kSize);
  for (int co = 0; co < Shape::kOut; ++co) {
    for (int y = 0; y < kOutSize; ++y) {
      for (int x = 0; x < kOutSize; ++x) {
        const Real g = d_out[(co * kOutSize + y) * kOutSize + x];
        d_bias[co] += g;
        for (int tap = 0; tap < Shape::kWeightsPerOut; ++tap) {
          const int ci = tap / Shape::kTaps, ky = tap % Shape::kTaps / kKernel, kx = tap % kKernel;
          const int pixel = (ci * kSize + 2 * y + ky) * kSize + 2 * x + kx;
          d_weight[co * Shape::kWeightsPerOut + tap] += double{g} * double{in[pixel]};
          if (d_in != nullptr) d_in[pixel] += weight[co * Shape::kWeightsPerOut + tap] * g;
        }
      }
    }
  }
  if (d_in == nullptr) return;
  for (int i = 0; i < Shape::kIn * kSize * kSize; ++i) {
    if (in[i] <= 0) d_in[i] = 0;
  }
}

template <class Real>
void Forward(const uint8_t* context, const Params<Real>& params, Image<Real>& image, Outputs<Real>& out) {
  Unpack(context, image);
  ForwardLayer<PaperConv1>(image.pixel, params.weight[0], params.bias[0], out.layer1);
  ForwardLayer<PaperConv2>(out.layer1, params.weight[1], params.bias[1], out.layer2);
  ForwardLayer<Conv3>(out.layer2, params.weight[2], params.bias[2], out.layer3);
  ForwardLayer<Conv4>(out.layer3, params.weight[3], params.bias[3], out.layer4);
  ForwardLayer<Conv5>(out.layer4, params.weight[4], params.bias[4], out.layer5);
}

// out: of Forward for this image. d_features: [256]. Adds to sums; image and d_out are scratch.
template <class Real>
void Backward(const uint8_t* context, const Params<Real>& params, const Outputs<Real>& out,
              const Real* d_features, Image<Real>& image, Outputs<Real>& d_out, GradientSums& sums) {
  Unpack(context, image);
  for (int i = 0; i < kConvFeatures; ++i) d_out.layer5[i] = out.layer5[i] <= 0 ? Real{0} : d_features[i];
  BackwardLayer<Conv5>(out.layer4, params.weight[4], d_out.layer5, sums.weight5, sums.bias5, d_out.layer4);
  BackwardLayer<Conv4>(out.layer3, params.weight[3], d_out.layer4, sums.weight4, sums.bias4, d_out.layer3);
  BackwardLayer<Conv3>(out.layer2, params.weight[2], d_out.layer3, sums.weight3, sums.bias3, d_out.layer2);
  BackwardLayer<PaperConv2>(out.layer1, params.weight[1], d_out.layer2, sums.weight2, sums.bias2,
                            d_out.layer1);
  BackwardLayer<PaperConv1>(image.pixel, params.weight[0], d_out.layer1, sums.weight1, sums.bias1,
                            static_cast<Real*>(nullptr));
}

}  // namespace dadrl::nn::reference
