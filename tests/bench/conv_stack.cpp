// Speed of the context encoder's convolutions on one core, next to the core's own multiply-add peak.
//
// Prints one JSON line a figure. GFLOP/s count the products of the paper's network (2 a multiply-add, no
// gradient for the image), whatever shortcuts the kernels take; the limit is a register-only FMA loop of the
// same instruction set, measured right before and after. Times are medians.
#include "common/nn/kernels/conv_stack.h"

#include <immintrin.h>
#include <time.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <new>
#include <random>
#include <string>
#include <vector>

#include "tests/bench/help.h"

namespace {

using dadrl::Isa;
namespace nn = dadrl::nn;

double ThreadSeconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

template <class Function>
double MedianSeconds(int repetitions, Function function) {
  std::vector<double> seconds;
  for (int i = 0; i < repetitions; ++i) {
    const double start = ThreadSeconds();
    function();
    seconds.push_back(ThreadSeconds() - start);
  }
  std::nth_element(seconds.begin(), seconds.begin() + repetitions / 2, seconds.end());
  return seconds[static_cast<size_t>(repetitions / 2)];
}

constexpr int kPeakSteps = 1 << 18;
constexpr int kChains = 16;  // enough to hide the latency of an FMA on two pipes

// Keeps the compiler from computing the loop in advance, or in fewer steps.
#define DADRL_OPAQUE(x) asm volatile("" : "+v"(x))

__attribute__((target("avx512f"))) void PeakAvx512() {
  __m512 sum[kChains], a = _mm512_set1_ps(0.5F), b = _mm512_set1_ps(1.0F);
  for (auto& s : sum) s = a;
  for (int i = 0; i < kPeakSteps; ++i) {
    DADRL_OPAQUE(a);
    for (auto& s : sum) s = _mm512_fmadd_ps(s, a, b);
  }
  for (auto& s : sum) DADRL_OPAQUE(s);
}

__attribute__((target("avx2,fma"))) void PeakAvx2() {
  __m256 sum[12], a = _mm256_set1_ps(0.5F), b = _mm256_set1_ps(1.0F);
  for (auto& s : sum) s = a;
  for (int i = 0; i < kPeakSteps; ++i) {
    DADRL_OPAQUE(a);
    for (auto& s : sum) s = _mm256_fmadd_ps(s, a, b);
  }
  for (auto& s : sum) DADRL_OPAQUE(s);
}

double PeakGflops(Isa isa) {
  const double flops = 2.0 * kPeakSteps * (isa == Isa::kAvx512 ? kChains * 16 : 12 * 8);
  return flops / MedianSeconds(15, isa == Isa::kAvx512 ? PeakAvx512 : PeakAvx2) * 1e-9;
}

// Multiply-adds of the paper's network for one image.
template <class Shape>
constexpr double Products() {
  return static_cast<double>(Shape::kWeights) * Shape::kOutSize * Shape::kOutSize;
}
constexpr double kLaterLayers =
    Products<nn::PaperConv2>() + Products<nn::Conv3>() + Products<nn::Conv4>() + Products<nn::Conv5>();
constexpr double kForwardFlops = 2 * (Products<nn::PaperConv1>() + kLaterLayers);
constexpr double kBackwardFlops = kForwardFlops + 2 * kLaterLayers;

struct Aligned {
  explicit Aligned(size_t bytes) : memory(::operator new (bytes, std::align_val_t{64})) {}
  ~Aligned() { ::operator delete (memory, std::align_val_t{64}); }
  Aligned(const Aligned&) = delete;
  Aligned& operator=(const Aligned&) = delete;
  void* const memory;
};

struct Network {
  std::vector<float> weight[nn::kConvLayers], bias[nn::kConvLayers];
  std::vector<float> d_weight[nn::kConvLayers], d_bias[nn::kConvLayers];
  nn::ConvStackParams params;
  nn::ConvStackGrads grads;

  Network() {
    std::mt19937 random(1);
    std::normal_distribution<float> normal(0.0F, 0.1F);
    for (int l = 0; l < nn::kConvLayers; ++l) {
      weight[l].resize(nn::ConvStackWeightCount(l));
      bias[l].resize(nn::ConvStackBiasCount(l));
      for (float& w : weight[l]) w = normal(random);
      for (float& b : bias[l]) b = normal(random);
      d_weight[l].resize(weight[l].size());
      d_bias[l].resize(bias[l].size());
      params.weight[l] = weight[l].data(), params.bias[l] = bias[l].data();
      grads.weight[l] = d_weight[l].data(), grads.bias[l] = d_bias[l].data();
    }
  }
};

std::vector<uint8_t> Noise(int count) {
  std::mt19937 random(2);
  std::vector<uint8_t> bytes(static_cast<size_t>(count) * nn::kContextImageBytes);
  for (auto& byte : bytes) byte = static_cast<uint8_t>(random());
  return bytes;
}

// What the encoder sees: a crossing, seen from a random place and heading, and a route band ahead of the ego.
std::vector<uint8_t> Roads(int count) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<uint8_t> bytes(static_cast<size_t>(count) * nn::kContextImageBytes, 0);
  for (int n = 0; n < count; ++n) {
    uint8_t* const image = bytes.data() + static_cast<size_t>(n) * nn::kContextImageBytes;
    const double slope = 0.3 * unit(random), x0 = 64 + 10 * unit(random), y0 = 40 + 30 * unit(random);
    const double bend = 0.01 * unit(random);
    for (int row = 0; row < nn::kContextSide; ++row) {
      for (int column = 0; column < nn::kContextSide; ++column) {
        const double across = column - x0 - slope * (row - y0), along = row - y0 + slope * (column - x0);
        const double ahead = 64 - row;
        const bool drivable = std::abs(across) < 18 || std::abs(along) < 18;
        const bool route = ahead >= 0 && ahead < 82 && std::abs(column - 64 - bend * ahead * ahead) < 2.6;
        const auto bit = static_cast<uint8_t>(1U << (column % 8));
        if (drivable) image[row * 16 + column / 8] |= bit;
        if (route) image[(nn::kContextSide + row) * 16 + column / 8] |= bit;
      }
    }
  }
  return bytes;
}

void Print(const std::string& name, double value, const char* unit, double limit, double of_limit) {
  std::printf(
      "{\"bench\": \"conv_stack\", \"case\": \"%s\", \"value\": %.4g, \"unit\": \"%s\", "
      "\"limit\": %.4g, \"of_limit\": %.3f}\n",
      name.c_str(), value, unit, limit, of_limit);
}

void MeasureBatch(Isa isa, int batch, const std::string& images, const std::vector<uint8_t>& context) {
  Network network;
  const Aligned activations(nn::ConvStackActivationBytes(batch, true));
  std::vector<float> features(static_cast<size_t>(batch) * nn::kConvFeatures),
      d_features(features.size(), 0.1F);
  const int repetitions = 4 + 1200 / batch;
  const double peak_before = PeakGflops(isa);
  const auto forward = [&](bool keep) {
    return MedianSeconds(repetitions, [&] {
      nn::ConvStackForward(context.data(), batch, network.params, activations.memory, features.data(), keep);
    });
  };
  const double inference = forward(false), training = forward(true);
  const double backward = MedianSeconds(repetitions, [&] {
    nn::ConvStackBackward(context.data(), batch, network.params, activations.memory, d_features.data(),
                          network.grads);
  });
  const double peak = std::max(peak_before, PeakGflops(isa));
  const auto print = [&](const char* pass, double flops, double seconds) {
    const double gflops = flops * batch / seconds * 1e-9;
    Print(std::string(IsaName(isa)) + " " + pass + " b" + std::to_string(batch) + " " + images, gflops,
          "GFLOP/s", peak, gflops / peak);
  };
  print("forward", kForwardFlops, inference);
  print("forward-keep", kForwardFlops, training);
  print("backward", kBackwardFlops, backward);
}

void MeasureSingle(Isa isa, const std::string& images, const std::vector<uint8_t>& context) {
  Network network;
  nn::SingleImageConvStack single;
  single.Pack(network.params);
  std::vector<float> features(nn::kConvFeatures);
  const double peak = PeakGflops(isa);
  size_t n = 0;
  const double seconds = MedianSeconds(1000, [&] {
    single.Forward(context.data() + n * nn::kContextImageBytes, features.data());
    n = (n + 1) % (context.size() / nn::kContextImageBytes);
  });
  const double limit = kForwardFlops / peak * 1e-9;
  Print(std::string(IsaName(isa)) + " single " + images, seconds * 1e6, "us", limit * 1e6, limit / seconds);
}

}  // namespace

int main(int argc, char** argv) {
  if (dadrl::bench::HelpAsked(argc, argv, "conv_stack: speed of the context encoder's convolutions\n")) {
    return 0;
  }
  const auto roads = Roads(256), noise = Noise(64);
  for (Isa isa : {Isa::kAvx512, Isa::kAvx2}) {
    if (!SetIsa(isa)) continue;
    MeasureBatch(isa, 64, "roads", roads);
    MeasureBatch(isa, 256, "roads", roads);
    MeasureBatch(isa, 64, "noise", noise);
    MeasureSingle(isa, "roads", roads);
    MeasureSingle(isa, "noise", noise);
  }
}
