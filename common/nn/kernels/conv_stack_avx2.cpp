// Compiled with AVX2 and FMA; reached only through kConvKernels, on processors that have them.
#include "common/nn/kernels/conv_table.h"
#include "common/nn/kernels/simd/conv_stack_simd.h"
#include "common/nn/kernels/simd/first_layer_avx2.h"
#include "common/nn/kernels/simd/single_first_layer_avx2.h"
#include "common/nn/kernels/simd/single_image.h"
#include "common/nn/kernels/simd/vec_avx2.h"

namespace dadrl::nn::avx2 {
namespace {

// 16 registers.
struct Tiles {
  static constexpr simd::ForwardTiling kForward2 = {2, 5}, kForward3 = {2, 5}, kForward4 = {2, 5};
  static constexpr simd::ForwardTiling kForward5 = {4, 1};
  static constexpr simd::InputTiling kInput2 = {2, 2, 5}, kInput3 = {2, 2, 5}, kInput4 = {4, 2, 2};
  static constexpr simd::InputTiling kInput5 = {4, 2, 2};
  static constexpr simd::ImageLaneTiling kWeight2 = {2, 1}, kWeight3 = {2, 4};
  static constexpr simd::ChannelLaneTiling kWeight4 = {1, 2}, kWeight5 = {2, 2};
};

struct SingleTiles {
  static constexpr int kSingle2Channels = 2, kSingle2Vectors = 4;
  static constexpr int kSingle3Rows = 1, kSingle3Columns = 5, kSingle3Vectors = 2;
  static constexpr int kSingle4Rows = 1, kSingle4Columns = 5, kSingle4Vectors = 2;
  static constexpr int kSingle5Rows = 2, kSingle5Columns = 2, kSingle5Vectors = 2;
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

}  // namespace dadrl::nn::avx2
