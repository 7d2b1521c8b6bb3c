// One image through the stack, for acting. Lanes are columns of the output where images are large (layers 1
// and 2) and output channels where they are small (layers 3 to 5).
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "common/nn/kernels/conv_params.h"
#include "common/nn/kernels/simd/unroll.h"

namespace dadrl::nn::simd {

// The first layer's output: even and odd columns apart, because stride 2 then reads neighbours:
// [61 rows][4 channels][even, odd][32 columns]. Columns past the image hold anything.
constexpr int kHalfColumns = 32;
constexpr int kLayer1Row = Conv1::kOut * 2 * kHalfColumns;
// The second layer's: [8 channels][29 rows][32 columns].
constexpr int kLayer2Columns = 32;

template <class Simd, class SingleFirstLayer, class Tiles>
class SingleImage {
 public:
  struct alignas(64) Packed {
    SingleFirstLayer first;
    float weight2[Conv2::kWeights];  // [ci][ky][kx][co], as all that follow
    float weight3[Conv3::kWeights];
    float weight4[Conv4::kWeights];
    float weight5[Conv5::kWeights];
    float bias2[16];
    float bias3[Conv3::kOut];
    float bias4[Conv4::kOut];
    float bias5[Conv5::kOut];
  };

  struct alignas(64) Scratch {
    float layer1[Conv1::kOutSize * kLayer1Row + kHalfColumns];  // the last row's vectors reach past its end
    float layer2[Conv2::kOut * Conv2::kOutSize * kLayer2Columns];
    float layer3[Conv3::kOutElements];  // [row][column][channel], as all that follow
    float layer4[Conv4::kOutElements];
    float layer5[Conv5::kOutElements];
  };

  static void Pack(const ConvStackParams& params, float* packed) {
    auto& to = *reinterpret_cast<Packed*>(packed);
    to.first.SetParams(params.weight[0], params.bias[0]);
    PackLayer<Conv2>(params.weight[1], params.bias[1], to.weight2, to.bias2);
    PackLayer<Conv3>(params.weight[2], params.bias[2], to.weight3, to.bias3);
    PackLayer<Conv4>(params.weight[3], params.bias[3], to.weight4, to.bias4);
    PackLayer<Conv5>(params.weight[4], params.bias[4], to.weight5, to.bias5);
  }

  static void Forward(const uint8_t* context, const float* packed, float* scratch, float* features) {
    const auto& p = *reinterpret_cast<const Packed*>(packed);
    auto& work = *reinterpret_cast<Scratch*>(scratch);
    for (int y = 0; y < Conv1::kOutSize; ++y) p.first.ForwardRow(context, y, work.layer1 + y * kLayer1Row);
    for (int y = 0; y < Conv2::kOutSize; ++y) SecondLayerRow(p, work, y);
    constexpr int kPlane2 = Conv2::kOutSize * kLayer2Columns;
    Layer<Conv3, Tiles::kSingle3Rows, Tiles::kSingle3Columns, Tiles::kSingle3Vectors, kPlane2, kLayer2Columns,
          1>(work.layer2, p.weight3, p.bias3, work.layer3);
    Layer<Conv4, Tiles::kSingle4Rows, Tiles::kSingle4Columns, Tiles::kSingle4Vectors, 1,
          Conv4::kInSize * Conv4::kIn, Conv4::kIn>(work.layer3, p.weight4, p.bias4, work.layer4);
    Layer<Conv5, Tiles::kSingle5Rows, Tiles::kSingle5Columns, Tiles::kSingle5Vectors, 1,
          Conv5::kInSize * Conv5::kIn, Conv5::kIn>(work.layer4, p.weight5, p.bias5, work.layer5);
    constexpr int kPixels = Conv5::kOutSize * Conv5::kOutSize;
    for (int co = 0; co < Conv5::kOut; ++co) {
      for (int pixel = 0; pixel < kPixels; ++pixel) {
        features[co * kPixels + pixel] = work.layer5[pixel * Conv5::kOut + co];
      }
    }
  }

 private:
  using Float = typename Simd::Float;

  template <class Shape>
  static void PackLayer(const float* weight, const float* bias, float* packed_weight, float* packed_bias) {
    for (int co = 0; co < Shape::kOut; ++co) {
      packed_bias[co] = bias[co];
      for (int tap = 0; tap < Shape::kWeightsPerOut; ++tap) {
        packed_weight[tap * Shape::kOut + co] = weight[co * Shape::kWeightsPerOut + tap];
      }
    }
  }

  static void SecondLayerRow(const Packed& p, Scratch& work, int y) {
    constexpr int kChannels = Tiles::kSingle2Channels, kVectors = Tiles::kSingle2Vectors;
    static_assert(kLayer2Columns % (kVectors * Simd::kFloats) == 0 && Conv2::kOut % kChannels == 0);
    for (int x = 0; x < kLayer2Columns; x += kVectors * Simd::kFloats) {
      for (int co = 0; co < Conv2::kOut; co += kChannels) {
        SecondLayerTile<kChannels, kVectors>(p, work, y, x, co);
      }
    }
  }

  template <int kChannels, int kVectors>
  static void SecondLayerTile(const Packed& p, Scratch& work, int y, int x, int co) {
    Float sum[kChannels][kVectors];
    DADRL_UNROLL
    for (int c = 0; c < kChannels; ++c) {
      DADRL_UNROLL
      for (int v = 0; v < kVectors; ++v) sum[c][v] = Simd::Broadcast(p.bias2 + co + c);
    }
    for (int ci = 0; ci < Conv2::kIn; ++ci) {
      for (int ky = 0; ky < Conv2::kKernel; ++ky) {
        const float* const pixels = work.layer1 + (2 * y + ky) * kLayer1Row + ci * 2 * kHalfColumns + x;
        const float* const taps = p.weight2 + (ci * Conv2::kKernel + ky) * Conv2::kKernel * Conv2::kOut + co;
        DADRL_UNROLL
        for (int kx = 0; kx < Conv2::kKernel; ++kx) {
          Float pixel[kVectors];
          DADRL_UNROLL
          for (int v = 0; v < kVectors; ++v) {
            pixel[v] = Simd::LoadUnaligned(pixels + kx % 2 * kHalfColumns + kx / 2 + v * Simd::kFloats);
          }
          DADRL_UNROLL
          for (int c = 0; c < kChannels; ++c) {
            const Float w = Simd::Broadcast(taps + kx * Conv2::kOut + c);
            DADRL_UNROLL
            for (int v = 0; v < kVectors; ++v) sum[c][v] = Simd::Fma(w, pixel[v], sum[c][v]);
          }
        }
      }
    }
    DADRL_UNROLL
    for (int c = 0; c < kChannels; ++c) {
      DADRL_UNROLL
      for (int v = 0; v < kVectors; ++v) {
        Simd::Store(work.layer2 + ((co + c) * Conv2::kOutSize + y) * kLayer2Columns + x + v * Simd::kFloats,
                    Simd::Relu(sum[c][v]));
      }
    }
  }

  // Lanes are output channels; in is kPlane, kRow and kColumn floats a channel, row and column.
  template <class Shape, int kRows, int kColumns, int kVectors, int kPlane, int kRow, int kColumn>
  static void Layer(const float* in, const float* weight, const float* bias, float* out) {
    constexpr int kSize = Shape::kOutSize;
    constexpr int kLastRows = kSize % kRows, kLastColumns = kSize % kColumns;
    int y = 0;
    for (; y + kRows <= kSize; y += kRows) {
      int x = 0;
      for (; x + kColumns <= kSize; x += kColumns) {
        Tile<Shape, kRows, kColumns, kVectors, kPlane, kRow, kColumn>(in, weight, bias, out, y, x);
      }
      if constexpr (kLastColumns != 0) {
        Tile<Shape, kRows, kLastColumns, kVectors, kPlane, kRow, kColumn>(in, weight, bias, out, y, x);
      }
    }
    if constexpr (kLastRows != 0) {
      static_assert(kLastColumns == 0, "the corner is not covered");
      for (int x = 0; x < kSize; x += kColumns) {
        Tile<Shape, kLastRows, kColumns, kVectors, kPlane, kRow, kColumn>(in, weight, bias, out, y, x);
      }
    }
  }

  template <class Shape, int kRows, int kColumns, int kVectors, int kPlane, int kRow, int kColumn>
  static void Tile(const float* in, const float* weight, const float* bias, float* out, int y, int x) {
    constexpr int kTileLanes = kVectors * Simd::kFloats;
    static_assert(Shape::kOut % kTileLanes == 0);
    in += 2 * y * kRow + 2 * x * kColumn;
    out += (y * Shape::kOutSize + x) * Shape::kOut;
    for (int co = 0; co < Shape::kOut; co += kTileLanes) {
      Float sum[kRows][kColumns][kVectors];
      DADRL_UNROLL
      for (int i = 0; i < kRows; ++i) {
        DADRL_UNROLL
        for (int j = 0; j < kColumns; ++j) {
          DADRL_UNROLL
          for (int v = 0; v < kVectors; ++v) sum[i][j][v] = Simd::Load(bias + co + v * Simd::kFloats);
        }
      }
      const float* taps = weight + co;
      for (int ci = 0; ci < Shape::kIn; ++ci) {
        for (int ky = 0; ky < Shape::kKernel; ++ky) {
          const float* const pixels = in + ci * kPlane + ky * kRow;
          DADRL_UNROLL
          for (int kx = 0; kx < Shape::kKernel; ++kx, taps += Shape::kOut) {
            Float w[kVectors];
            DADRL_UNROLL
            for (int v = 0; v < kVectors; ++v) w[v] = Simd::Load(taps + v * Simd::kFloats);
            DADRL_UNROLL
            for (int i = 0; i < kRows; ++i) {
              DADRL_UNROLL
              for (int j = 0; j < kColumns; ++j) {
                const Float pixel = Simd::Broadcast(pixels + 2 * i * kRow + (2 * j + kx) * kColumn);
                DADRL_UNROLL
                for (int v = 0; v < kVectors; ++v) sum[i][j][v] = Simd::Fma(w[v], pixel, sum[i][j][v]);
              }
            }
          }
        }
      }
      DADRL_UNROLL
      for (int i = 0; i < kRows; ++i) {
        DADRL_UNROLL
        for (int j = 0; j < kColumns; ++j) {
          DADRL_UNROLL
          for (int v = 0; v < kVectors; ++v) {
            float* const to = out + (i * Shape::kOutSize + j) * Shape::kOut + co + v * Simd::kFloats;
            Simd::Store(to, Simd::Relu(sum[i][j][v]));
          }
        }
      }
    }
  }
};

}  // namespace dadrl::nn::simd
