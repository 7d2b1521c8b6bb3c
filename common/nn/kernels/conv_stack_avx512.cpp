// Compiled with AVX-512 (F, BW, DQ, VL) and FMA; reached only through kConvKernels, on processors that have
// them.
#include "common/nn/kernels/conv_table.h"
#include "common/nn/kernels/simd/conv_stack_simd.h"
#include "common/nn/kernels/simd/first_layer_avx512.h"
#include "common/nn/kernels/simd/single_first_layer_avx512.h"
#include "common/nn/kernels/simd/single_image.h"
#include "common/nn/kernels/simd/vec_avx512.h"

namespace dadrl::nn::avx512 {
namespace {

// 32 registers. Measured on Zen 5, like those of AVX2: within a tenth of the FMA peak.
struct Tiles {
  static constexpr simd::ForwardTiling kForward2 = {4, 5}, kForward3 = {4, 5}, kForward4 = {4, 5};
  static constexpr simd::ForwardTiling kForward5 = {4, 2};
  static constexpr simd::InputTiling kInput2 = {2, 2, 11}, kInput3 = {2, 2, 8}, kInput4 = {2, 2, 7};
  static constexpr simd::InputTiling kInput5 = {4, 2, 3};
  static constexpr simd::ImageLaneTiling kWeight2 = {4, 2}, kWeight3 = {4, 4};
  static constexpr simd::ChannelLaneTiling kWeight4 = {2, 2}, kWeight5 = {2, 4};
};

struct SingleTiles {
  static constexpr int kSingle2Channels = 8, kSingle2Vectors = 2;
  static constexpr int kSingle3Rows = 1, kSingle3Columns = 13, kSingle3Vectors = 1;
  static constexpr int kSingle4Rows = 2, kSingle4Columns = 5, kSingle4Vectors = 2;
  static constexpr int kSingle5Rows = 2, kSingle5Columns = 2, kSingle5Vectors = 4;
};

using Stack = simd::ConvStack<Simd, FirstLayer, Tiles>;
using Single = simd::SingleImage<Simd, SingleFirstLayer, SingleTiles>;

}  // namespace

const ConvKernelTable kConvKernels = {
    sizeof(Stack::Outputs) / sizeof(float),
    sizeof(Stack::Scratch) / sizeof(float),
    Stack::Forward,
    Stack::Backward,
    sizeof(Single::Packed) / sizeof(float),
    sizeof(Single::Scratch) / sizeof(float),
    Single::Pack,
    Single::Forward,
};

}  // namespace dadrl::nn::avx512
