// The portable implementation: for processors without AVX2, and the oracle of the tests.
#include <algorithm>
#include <cstring>

#include "common/nn/kernels/conv_reference.h"
#include "common/nn/kernels/conv_table.h"

namespace dadrl::nn::scalar {
namespace {

using Outputs = reference::Outputs<float>;

struct Scratch {
  reference::GradientSums sums;
  reference::Image<float> image;
  Outputs d_out;
};

reference::Params<float> ToReference(const ConvStackParams& params) {
  reference::Params<float> result;
  for (int l = 0; l < kConvLayers; ++l) {
    result.weight[l] = params.weight[l];
    result.bias[l] = params.bias[l];
  }
  return result;
}

// Where feature 0 of image `n` stands; the next is kLanes on.
int PlaceOf(int n) { return n / kLanes * kLanes * kConvFeatures + n % kLanes; }

void Forward(const uint8_t* context, int batch, const ConvStackParams& params, float* groups, float* scratch,
             float* features, bool keep) {
  auto* const outputs = reinterpret_cast<Outputs*>(groups);
  auto* const work = reinterpret_cast<Scratch*>(scratch);
  for (int n = 0; n < batch; ++n) {
    Outputs& out = outputs[keep ? n : 0];
    reference::Forward(context + n * kContextImageBytes, ToReference(params), work->image, out);
    for (int i = 0; i < kConvFeatures; ++i) features[PlaceOf(n) + i * kLanes] = out.layer5[i];
  }
}

void Store(const double* sums, int count, float* out) {
  for (int i = 0; i < count; ++i) out[i] = sums[i];
}

void Backward(const uint8_t* context, int batch, const ConvStackParams& params, const float* groups,
              float* scratch, const float* d_features, const ConvStackGrads& grads) {
  const auto* const outputs = reinterpret_cast<const Outputs*>(groups);
  auto* const work = reinterpret_cast<Scratch*>(scratch);
  std::memset(&work->sums, 0, sizeof(work->sums));
  for (int n = 0; n < batch; ++n) {
    float d_image[kConvFeatures];
    for (int i = 0; i < kConvFeatures; ++i) d_image[i] = d_features[PlaceOf(n) + i * kLanes];
    reference::Backward(context + n * kContextImageBytes, ToReference(params), outputs[n], d_image,
                        work->image, work->d_out, work->sums);
  }
  const auto& sums = work->sums;
  const double* const weights[] = {sums.weight1, sums.weight2, sums.weight3, sums.weight4, sums.weight5};
  const double* const biases[] = {sums.bias1, sums.bias2, sums.bias3, sums.bias4, sums.bias5};
  for (int l = 0; l < kConvLayers; ++l) {
    Store(weights[l], kConvLayerShapes[l].weights, grads.weight[l]);
    Store(biases[l], kConvLayerShapes[l].out, grads.bias[l]);
  }
}

struct SinglePacked {
  float weight1[PaperConv1::kWeights], weight2[PaperConv2::kWeights], weight3[Conv3::kWeights];
  float weight4[Conv4::kWeights], weight5[Conv5::kWeights];
  float bias1[PaperConv1::kOut], bias2[PaperConv2::kOut], bias3[Conv3::kOut], bias4[Conv4::kOut];
  float bias5[Conv5::kOut];
};

void SinglePack(const ConvStackParams& params, float* packed) {
  auto* const p = reinterpret_cast<SinglePacked*>(packed);
  float* const weights[] = {p->weight1, p->weight2, p->weight3, p->weight4, p->weight5};
  float* const biases[] = {p->bias1, p->bias2, p->bias3, p->bias4, p->bias5};
  for (int l = 0; l < kConvLayers; ++l) {
    std::copy_n(params.weight[l], kConvLayerShapes[l].weights, weights[l]);
    std::copy_n(params.bias[l], kConvLayerShapes[l].out, biases[l]);
  }
}

struct SingleScratch {
  reference::Image<float> image;
  Outputs out;
};

void SingleForward(const uint8_t* context, const float* packed, float* scratch, float* features) {
  const auto* const p = reinterpret_cast<const SinglePacked*>(packed);
  auto* const work = reinterpret_cast<SingleScratch*>(scratch);
  const reference::Params<float> params = {{p->weight1, p->weight2, p->weight3, p->weight4, p->weight5},
                                           {p->bias1, p->bias2, p->bias3, p->bias4, p->bias5}};
  reference::Forward(context, params, work->image, work->out);
  std::memcpy(features, work->out.layer5, sizeof(work->out.layer5));
}

}  // namespace

const ConvKernelTable kConvKernels = {
    kLanes * sizeof(Outputs) / sizeof(float),
    sizeof(Scratch) / sizeof(float),
    Forward,
    Backward,
    sizeof(SinglePacked) / sizeof(float),
    sizeof(SingleScratch) / sizeof(float),
    SinglePack,
    SingleForward,
};

}  // namespace dadrl::nn::scalar
