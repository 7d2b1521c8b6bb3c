// The whole stack on one instruction set, 16 images at a time. Tiles gives the register tile of each layer,
// FirstLayer the layer whose input is bits.
#pragma once

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "common/nn/kernels/conv_params.h"
#include "common/nn/kernels/simd/forward.h"
#include "common/nn/kernels/simd/input_gradient.h"
#include "common/nn/kernels/simd/weight_gradient.h"

namespace dadrl::nn::simd {

template <class Simd, class FirstLayer, class Tiles>
class ConvStack {
 public:
  // Outputs of one group, each [channel][row][column][16 images].
  struct alignas(64) Outputs {
    float layer1[Conv1::kOutElements * kLanes];
    float layer2[Conv2::kOutElements * kLanes];
    float layer3[Conv3::kOutElements * kLanes];
    float layer4[Conv4::kOutElements * kLanes];
    float layer5[Conv5::kOutElements * kLanes];
  };

  struct alignas(64) Scratch {
    FirstLayer first;
    // Gradients before each layer's ReLU; of the first layer one row, used at once.
    float d_row1[Conv1::kOut * Conv1::kOutSize * kLanes];
    float d_layer2[Conv2::kOutElements * kLanes];
    float d_layer3[Conv3::kOutElements * kLanes];
    float d_layer4[Conv4::kOutElements * kLanes];
    float d_layer5[Conv5::kOutElements * kLanes];
    float channels_last[Conv4::kOutElements * kLanes];
    struct Sums {  // over the groups of the batch
      float weight2[Conv2::kWeights * kLanes];
      float weight3[Conv3::kWeights * kLanes];
      float weight4[Conv4::kWeights];
      float weight5[Conv5::kWeights];
      float bias1[Conv1::kOut * kLanes];
      float bias2[Conv2::kOut * kLanes];
      float bias3[Conv3::kOut * kLanes];
      float bias4[Conv4::kOut * kLanes];
      float bias5[Conv5::kOut * kLanes];
    } sums;
  };

  static void Forward(const uint8_t* context, int batch, const ConvStackParams& params, float* groups,
                      float* scratch, float* features, bool keep) {
    auto& work = *reinterpret_cast<Scratch*>(scratch);
    auto* const outputs = reinterpret_cast<Outputs*>(groups);
    work.first.SetParams(params.weight[0], params.bias[0]);
    for (int group = 0; group < batch / kLanes; ++group) {
      Outputs& out = outputs[keep ? group : 0];
      work.first.SetGroup(context + group * kLanes * kContextImageBytes);
      ForwardGroup(params, work.first, out);
      memcpy(features + group * kLanes * kConvFeatures, out.layer5, sizeof(out.layer5));
    }
  }

  static void Backward(const uint8_t* context, int batch, const ConvStackParams& params, const float* groups,
                       float* scratch, const float* d_features, const ConvStackGrads& grads) {
    auto& work = *reinterpret_cast<Scratch*>(scratch);
    const auto* const outputs = reinterpret_cast<const Outputs*>(groups);
    memset(&work.sums, 0, sizeof(work.sums));
    work.first.ClearGradient();
    for (int group = 0; group < batch / kLanes; ++group) {
      work.first.SetGroup(context + group * kLanes * kContextImageBytes);
      BackwardGroup(params, outputs[group], d_features + group * kLanes * kConvFeatures, work);
    }
    StoreGradients(work, grads);
  }

 private:
  static void ForwardGroup(const ConvStackParams& params, FirstLayer& first, Outputs& out) {
    // The second layer follows the first row by row, while those rows are in the cache.
    int rows1 = 0;
    for (int y = 0; y < Conv2::kOutSize; ++y) {
      for (; rows1 < 2 * y + Conv2::kKernel; ++rows1) first.ForwardRow(rows1, out.layer1);
      ForwardRows<Simd, Conv2, Tiles::kForward2.channels, 1, Tiles::kForward2.columns>(
          out.layer1, params.weight[1], params.bias[1], out.layer2, y);
    }
    for (int y = 0; y < Conv3::kOutSize; ++y) {
      ForwardRows<Simd, Conv3, Tiles::kForward3.channels, 1, Tiles::kForward3.columns>(
          out.layer2, params.weight[2], params.bias[2], out.layer3, y);
    }
    for (int y = 0; y < Conv4::kOutSize; ++y) {
      ForwardRows<Simd, Conv4, Tiles::kForward4.channels, 1, Tiles::kForward4.columns>(
          out.layer3, params.weight[3], params.bias[3], out.layer4, y);
    }
    ForwardRows<Simd, Conv5, Tiles::kForward5.channels, 2, Tiles::kForward5.columns>(
        out.layer4, params.weight[4], params.bias[4], out.layer5, 0);
  }

  static void LoadFeatureGradients(const float* d_features, const float* layer5, float* d_layer5) {
    for (int i = 0; i < kConvFeatures * kLanes; i += Simd::kFloats) {
      Simd::Store(d_layer5 + i,
                  Simd::ReluGradient(Simd::Load(layer5 + i), Simd::LoadUnaligned(d_features + i)));
    }
  }

  static void BackwardGroup(const ConvStackParams& params, const Outputs& out, const float* d_features,
                            Scratch& work) {
    auto& sums = work.sums;
    LoadFeatureGradients(d_features, out.layer5, work.d_layer5);
    BiasGradient<Simd, Conv5>(work.d_layer5, sums.bias5);
    ChannelsLast<Simd, Conv5>(work.d_layer5, work.channels_last);
    WeightGradientChannelLanes<Simd, Conv5, Tiles::kWeight5.channels, Tiles::kWeight5.vectors>(
        out.layer4, work.channels_last, sums.weight5);
    InputGradientImage<Conv5, Tiles::kInput5.channels, Tiles::kInput5.step, Tiles::kInput5.columns>(
        work.d_layer5, params.weight[4], out.layer4, work.d_layer4);

    BiasGradient<Simd, Conv4>(work.d_layer4, sums.bias4);
    ChannelsLast<Simd, Conv4>(work.d_layer4, work.channels_last);
    WeightGradientChannelLanes<Simd, Conv4, Tiles::kWeight4.channels, Tiles::kWeight4.vectors>(
        out.layer3, work.channels_last, sums.weight4);
    InputGradientImage<Conv4, Tiles::kInput4.channels, Tiles::kInput4.step, Tiles::kInput4.columns>(
        work.d_layer4, params.weight[3], out.layer3, work.d_layer3);

    BiasGradient<Simd, Conv3>(work.d_layer3, sums.bias3);
    constexpr int kBand3 = Tiles::kWeight3.band;
    for (int y = 0; y < Conv3::kOutSize; y += kBand3) {
      WeightGradientImageLanes<Simd, Conv3, Tiles::kWeight3.channels>(
          out.layer2, work.d_layer3, sums.weight3, y, Smaller(kBand3, Conv3::kOutSize - y));
    }
    InputGradientImage<Conv3, Tiles::kInput3.channels, Tiles::kInput3.step, Tiles::kInput3.columns>(
        work.d_layer3, params.weight[2], out.layer2, work.d_layer2);

    BiasGradient<Simd, Conv2>(work.d_layer2, sums.bias2);
    BackwardFirstLayers(params, out, work);
  }

  // The output of the first layer, the largest tensor, is read once; its gradient exists one row at a time.
  static void BackwardFirstLayers(const ConvStackParams& params, const Outputs& out, Scratch& work) {
    constexpr int kRow = Conv1::kOutSize * kLanes, kBand = Tiles::kWeight2.band;
    int row1 = 0;
    for (int y = 0; y < Conv2::kOutSize; y += kBand) {
      const int rows = Smaller(kBand, Conv2::kOutSize - y);
      WeightGradientImageLanes<Simd, Conv2, Tiles::kWeight2.channels>(out.layer1, work.d_layer2,
                                                                      work.sums.weight2, y, rows);
      const int row1_end = y + rows == Conv2::kOutSize ? Conv1::kOutSize : 2 * (y + rows);
      for (; row1 < row1_end; ++row1) {
        InputGradient<Simd, Conv2, Tiles::kInput2.channels, Tiles::kInput2.step, Tiles::kInput2.columns>(
            work.d_layer2, params.weight[1], out.layer1, work.d_row1, kRow, row1);
        AddBiasGradient<Simd, Conv1::kOut, Conv1::kOutSize>(work.d_row1, work.sums.bias1);
        work.first.AddGradientRow(row1, work.d_row1);
      }
    }
  }

  static constexpr int Smaller(int a, int b) { return a < b ? a : b; }

  template <class Shape, int kChannels, int kStep, int kColumns>
  static void InputGradientImage(const float* d_out, const float* weight, const float* in, float* d_in) {
    constexpr int kRow = Shape::kInSize * kLanes;
    for (int y = 0; y < Shape::kInSize; ++y) {
      InputGradient<Simd, Shape, kChannels, kStep, kColumns>(d_out, weight, in, d_in + y * kRow,
                                                             Shape::kInSize * kRow, y);
    }
  }

  static void StoreGradients(const Scratch& work, const ConvStackGrads& grads) {
    work.first.StoreGradient(grads.weight[0]);
    ReduceImageLanes<Simd, Conv2, Tiles::kWeight2.channels>(work.sums.weight2, grads.weight[1]);
    ReduceImageLanes<Simd, Conv3, Tiles::kWeight3.channels>(work.sums.weight3, grads.weight[2]);
    ReduceChannelLanes<Simd, Conv4>(work.sums.weight4, grads.weight[3]);
    ReduceChannelLanes<Simd, Conv5>(work.sums.weight5, grads.weight[4]);
    const float* const biases[] = {work.sums.bias1, work.sums.bias2, work.sums.bias3, work.sums.bias4,
                                   work.sums.bias5};
    constexpr int kCounts[] = {Conv1::kOut, Conv2::kOut, Conv3::kOut, Conv4::kOut, Conv5::kOut};
    for (int l = 0; l < kConvLayers; ++l) {
      for (int co = 0; co < kCounts[l]; ++co) {
        grads.bias[l][co] = SumOfLanes<Simd>(biases[l] + co * kLanes);
      }
    }
  }
};

// Register tiles, chosen by measurement.
struct ForwardTiling {
  int channels, columns;
};
struct InputTiling {
  int channels, step, columns;
};
struct ImageLaneTiling {
  int channels, band;
};
struct ChannelLaneTiling {
  int channels, vectors;
};

}  // namespace dadrl::nn::simd
