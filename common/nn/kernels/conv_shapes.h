// Shapes of the context encoder's five convolutions (paper, section IV: stride 2, no padding, ReLU after
// each).
//
// Included by the kernel translation units, which are compiled for different processors: nothing here may
// become a function in the object file, or the linker could pick one that another processor cannot run.
#pragma once

namespace dadrl::nn {

// A convolution of square images with stride 2. Weights are [kOut][kIn][kKernel][kKernel].
template <int kInChannels, int kInPixels, int kOutChannels, int kKernelPixels>
struct ConvShape {
  static constexpr int kIn = kInChannels;
  static constexpr int kInSize = kInPixels;
  static constexpr int kOut = kOutChannels;
  static constexpr int kKernel = kKernelPixels;
  static constexpr int kOutSize = (kInSize - kKernel) / 2 + 1;
  static constexpr int kTaps = kKernel * kKernel;
  static constexpr int kWeightsPerOut = kIn * kTaps;
  static constexpr int kWeights = kOut * kWeightsPerOut;
  static constexpr int kOutElements = kOut * kOutSize * kOutSize;
};

inline constexpr int kConvLayers = 5;
inline constexpr int kContextSide = 128;
inline constexpr int kContextPlanes = 2;
inline constexpr int kContextImageBytes = kContextPlanes * kContextSide * kContextSide / 8;
inline constexpr int kConvFeatures = 256;

// As in the paper; the reference computes these.
using PaperConv1 = ConvShape<2, 128, 4, 5>;
using PaperConv2 = ConvShape<4, 62, 8, 5>;
using Conv3 = ConvShape<8, 29, 16, 5>;
using Conv4 = ConvShape<16, 13, 32, 5>;
using Conv5 = ConvShape<32, 5, 64, 3>;

// What the kernels compute: the second layer never reads row and column 61 of the first layer's output
// (2 * 28 + 4 = 60), so they do not exist there, nor does their gradient, which is zero.
using Conv1 = ConvShape<2, 125, 4, 5>;
using Conv2 = ConvShape<4, 61, 8, 5>;
static_assert(Conv1::kOutSize == Conv2::kInSize && Conv2::kOutSize == PaperConv2::kOutSize);
static_assert(Conv5::kOutElements == kConvFeatures);

template <class Shape, class Next>
inline constexpr bool kConvFollows = (Shape::kOut == Next::kIn) && (Shape::kOutSize == Next::kInSize);
static_assert(PaperConv1::kIn == kContextPlanes && PaperConv1::kInSize == kContextSide);
static_assert(kConvFollows<PaperConv1, PaperConv2> && kConvFollows<PaperConv2, Conv3>);
static_assert(kConvFollows<Conv1, Conv2> && kConvFollows<Conv2, Conv3>);
static_assert(kConvFollows<Conv3, Conv4> && kConvFollows<Conv4, Conv5>);
template <class Shape, class Other>
inline constexpr bool kSameConvWeights = (Shape::kIn == Other::kIn) && (Shape::kOut == Other::kOut) &&
                                         (Shape::kKernel == Other::kKernel);
static_assert(kSameConvWeights<Conv1, PaperConv1> && kSameConvWeights<Conv2, PaperConv2>);

// The same by layer, for what goes over them all: weights are [out][in][kernel][kernel].
struct ConvLayerShape {
  int out;
  int in;
  int kernel;
  int weights;
};
template <class Shape>
inline constexpr ConvLayerShape kConvLayerShapeOf = {Shape::kOut, Shape::kIn, Shape::kKernel,
                                                     Shape::kWeights};
inline constexpr ConvLayerShape kConvLayerShapes[kConvLayers] = {
    kConvLayerShapeOf<Conv1>, kConvLayerShapeOf<Conv2>, kConvLayerShapeOf<Conv3>, kConvLayerShapeOf<Conv4>,
    kConvLayerShapeOf<Conv5>};

}  // namespace dadrl::nn
