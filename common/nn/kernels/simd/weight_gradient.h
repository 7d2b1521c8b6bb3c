// Gradient of one convolution with respect to its weights and biases, over a group of 16 images.
//
// Two ways to use the lanes. Early layers, few weights and many pixels: lanes are images, and one sum over
// the lanes follows at the end of the batch. Late layers, many weights and few pixels, where those sums would
// cost as much as the products: lanes are output channels, the gradient transposed first.
#pragma once

#include "common/nn/kernels/conv_params.h"
#include "common/nn/kernels/simd/unroll.h"

namespace dadrl::nn::simd {

// Adds output rows y .. y + rows - 1 of channels co .. co + kChannels - 1, input channel ci, kernel row ky,
// to sums [kChannels][kKernel][16 images].
template <class Simd, class Shape, int kChannels>
void ImageLaneTile(const float* in, const float* d_out, float* sums, int co, int ci, int ky, int y,
                   int rows) {
  using Float = typename Simd::Float;
  constexpr int kKernel = Shape::kKernel;
  constexpr int kInRow = Shape::kInSize * kLanes, kInPlane = Shape::kInSize * kInRow;
  constexpr int kOutRow = Shape::kOutSize * kLanes, kOutPlane = Shape::kOutSize * kOutRow;
  Float sum[kChannels][kKernel];
  DADRL_UNROLL
  for (int c = 0; c < kChannels; ++c) {
    DADRL_UNROLL
    for (int kx = 0; kx < kKernel; ++kx) sum[c][kx] = Simd::Load(sums + (c * kKernel + kx) * kLanes);
  }
  const float* pixels = in + ci * kInPlane + (2 * y + ky) * kInRow;
  const float* gradients = d_out + co * kOutPlane + y * kOutRow;
  for (int row = 0; row < rows; ++row, pixels += 2 * kInRow, gradients += kOutRow) {
    for (int x = 0; x < Shape::kOutSize; ++x) {
      Float gradient[kChannels];
      DADRL_UNROLL
      for (int c = 0; c < kChannels; ++c) gradient[c] = Simd::Load(gradients + c * kOutPlane + x * kLanes);
      DADRL_UNROLL
      for (int kx = 0; kx < kKernel; ++kx) {
        const Float pixel = Simd::Load(pixels + (2 * x + kx) * kLanes);
        DADRL_UNROLL
        for (int c = 0; c < kChannels; ++c) sum[c][kx] = Simd::Fma(gradient[c], pixel, sum[c][kx]);
      }
    }
  }
  DADRL_UNROLL
  for (int c = 0; c < kChannels; ++c) {
    DADRL_UNROLL
    for (int kx = 0; kx < kKernel; ++kx) Simd::Store(sums + (c * kKernel + kx) * kLanes, sum[c][kx]);
  }
}

// Lanes are images. Adds what output rows y .. y + rows - 1 contribute to sums
// [kOut / kChannels][kIn][ky][kChannels][kx][16 images]. Few rows at a time stay in the first-level cache.
template <class Simd, class Shape, int kChannels>
void WeightGradientImageLanes(const float* in, const float* d_out, float* sums, int y, int rows) {
  constexpr int kKernel = Shape::kKernel, kTile = kChannels * kKernel * kLanes;
  static_assert(Shape::kOut % kChannels == 0);
  for (int lane = 0; lane < kLanes; lane += Simd::kFloats) {
    for (int ci = 0; ci < Shape::kIn; ++ci) {
      for (int co = 0; co < Shape::kOut; co += kChannels) {
        for (int ky = 0; ky < kKernel; ++ky) {
          const int tile = (co / kChannels * Shape::kIn + ci) * kKernel + ky;
          ImageLaneTile<Simd, Shape, kChannels>(in + lane, d_out + lane, sums + tile * kTile + lane, co, ci,
                                                ky, y, rows);
        }
      }
    }
  }
}

template <class Simd>
float SumOfLanes(const float* values) {
  typename Simd::Float sum = Simd::Load(values);
  for (int lane = Simd::kFloats; lane < kLanes; lane += Simd::kFloats) {
    sum = Simd::Add(sum, Simd::Load(values + lane));
  }
  return Simd::Sum(sum);
}

// From the sums of WeightGradientImageLanes to PyTorch's layout.
template <class Simd, class Shape, int kChannels>
void ReduceImageLanes(const float* sums, float* d_weight) {
  constexpr int kKernel = Shape::kKernel;
  for (int co = 0; co < Shape::kOut; ++co) {
    for (int tap = 0; tap < Shape::kIn * kKernel; ++tap) {
      const int tile = (co / kChannels * Shape::kIn * kKernel + tap) * kChannels + co % kChannels;
      for (int kx = 0; kx < kKernel; ++kx) {
        d_weight[co * Shape::kWeightsPerOut + tap * kKernel + kx] =
            SumOfLanes<Simd>(sums + (tile * kKernel + kx) * kLanes);
      }
    }
  }
}

// [channel][pixel][16 images] to [pixel][16 images][channel].
template <class Simd, class Shape>
void ChannelsLast(const float* d_out, float* transposed) {
  constexpr int kPixels = Shape::kOutSize * Shape::kOutSize;
  for (int pixel = 0; pixel < kPixels; ++pixel) {
    for (int n = 0; n < kLanes; ++n) {
      float* const to = transposed + (pixel * kLanes + n) * Shape::kOut;
      const float* const from = d_out + pixel * kLanes + n;
      for (int co = 0; co < Shape::kOut; ++co) to[co] = from[co * kPixels * kLanes];
    }
  }
}

// Lanes are output channels: kVectors registers of them, from channel co on. Adds the group's gradients for
// input channels ci .. ci + kChannels - 1 and kernel row ky to sums [kIn][ky][kx][kOut].
template <class Simd, class Shape, int kChannels, int kVectors>
void ChannelLaneTile(const float* in, const float* gradients, float* sums, int co, int ci, int ky) {
  using Float = typename Simd::Float;
  constexpr int kKernel = Shape::kKernel;
  constexpr int kInRow = Shape::kInSize * kLanes, kInPlane = Shape::kInSize * kInRow;
  Float sum[kChannels][kKernel][kVectors];
  sums += (ci * kKernel + ky) * kKernel * Shape::kOut + co;
  const auto at = [=](int c, int kx, int v) {
    return sums + (c * Shape::kTaps + kx) * Shape::kOut + v * Simd::kFloats;
  };
  DADRL_UNROLL
  for (int c = 0; c < kChannels; ++c) {
    DADRL_UNROLL
    for (int kx = 0; kx < kKernel; ++kx) {
      DADRL_UNROLL
      for (int v = 0; v < kVectors; ++v) sum[c][kx][v] = Simd::Load(at(c, kx, v));
    }
  }
  gradients += co;
  for (int y = 0; y < Shape::kOutSize; ++y) {
    for (int x = 0; x < Shape::kOutSize; ++x) {
      const float* const pixels = in + ci * kInPlane + (2 * y + ky) * kInRow + 2 * x * kLanes;
      for (int n = 0; n < kLanes; ++n, gradients += Shape::kOut) {
        Float gradient[kVectors];
        DADRL_UNROLL
        for (int v = 0; v < kVectors; ++v) gradient[v] = Simd::Load(gradients + v * Simd::kFloats);
        DADRL_UNROLL
        for (int c = 0; c < kChannels; ++c) {
          DADRL_UNROLL
          for (int kx = 0; kx < kKernel; ++kx) {
            const Float pixel = Simd::Broadcast(pixels + c * kInPlane + kx * kLanes + n);
            DADRL_UNROLL
            for (int v = 0; v < kVectors; ++v) sum[c][kx][v] = Simd::Fma(gradient[v], pixel, sum[c][kx][v]);
          }
        }
      }
    }
  }
  DADRL_UNROLL
  for (int c = 0; c < kChannels; ++c) {
    DADRL_UNROLL
    for (int kx = 0; kx < kKernel; ++kx) {
      DADRL_UNROLL
      for (int v = 0; v < kVectors; ++v) Simd::Store(at(c, kx, v), sum[c][kx][v]);
    }
  }
}

// transposed: of ChannelsLast.
template <class Simd, class Shape, int kChannels, int kVectors>
void WeightGradientChannelLanes(const float* in, const float* transposed, float* sums) {
  constexpr int kOutputs = kVectors * Simd::kFloats;
  static_assert(Shape::kIn % kChannels == 0 && Shape::kOut % kOutputs == 0);
  for (int co = 0; co < Shape::kOut; co += kOutputs) {
    for (int ci = 0; ci < Shape::kIn; ci += kChannels) {
      for (int ky = 0; ky < Shape::kKernel; ++ky) {
        ChannelLaneTile<Simd, Shape, kChannels, kVectors>(in, transposed, sums, co, ci, ky);
      }
    }
  }
}

// From the sums of WeightGradientChannelLanes to PyTorch's layout.
template <class Simd, class Shape>
void ReduceChannelLanes(const float* sums, float* d_weight) {
  for (int co = 0; co < Shape::kOut; ++co) {
    for (int tap = 0; tap < Shape::kWeightsPerOut; ++tap) {
      d_weight[co * Shape::kWeightsPerOut + tap] = sums[tap * Shape::kOut + co];
    }
  }
}

// Adds the gradient of each bias over d_out [kOut][kPixels][16 images] to sums [kOut][16 images].
template <class Simd, int kOut, int kPixels>
void AddBiasGradient(const float* d_out, float* sums) {
  constexpr int kChains = 4;  // independent, to hide the latency of an addition
  for (int co = 0; co < kOut; ++co, sums += kLanes, d_out += kPixels * kLanes) {
    for (int lane = 0; lane < kLanes; lane += Simd::kFloats) {
      typename Simd::Float sum[kChains] = {Simd::Load(sums + lane), Simd::Zero(), Simd::Zero(), Simd::Zero()};
      const float* const gradients = d_out + lane;
      int pixel = 0;
      for (; pixel + kChains <= kPixels; pixel += kChains) {
        DADRL_UNROLL
        for (int i = 0; i < kChains; ++i) {
          sum[i] = Simd::Add(sum[i], Simd::Load(gradients + (pixel + i) * kLanes));
        }
      }
      for (; pixel < kPixels; ++pixel) sum[0] = Simd::Add(sum[0], Simd::Load(gradients + pixel * kLanes));
      Simd::Store(sums + lane, Simd::Add(Simd::Add(sum[0], sum[1]), Simd::Add(sum[2], sum[3])));
    }
  }
}

template <class Simd, class Shape>
void BiasGradient(const float* d_out, float* sums) {
  AddBiasGradient<Simd, Shape::kOut, Shape::kOutSize * Shape::kOutSize>(d_out, sums);
}

}  // namespace dadrl::nn::simd
