// The dense product on batch-in-lanes activations beside Eigen's on the same shapes, both beside the core's
// peak.
//
// Prints JSON lines, best of many short runs, AVX-512 only: it is why common/nn has a product of its own.
#include "tests/bench/dense_product.h"

#include <fmt/core.h>

#include <string>

#include "common/nn/aligned_buffer.h"
#include "common/nn/lanes/lane_kernels.h"
#include "tests/bench/core_peak.h"
#include "tests/bench/help.h"

namespace dadrl::bench {
namespace {

using nn::kLanes;

template <typename Function>
double BestSeconds(Function function) {
  double best = 1e9;
  for (int i = 0; i < 300; ++i) {
    const double start = Seconds();
    function();
    best = std::min(best, Seconds() - start);
  }
  return best;
}

nn::FloatBuffer Filled(int rows, int columns) {
  nn::FloatBuffer buffer(static_cast<size_t>(rows) * static_cast<size_t>(columns));
  for (size_t i = 0; i < buffer.size(); ++i) buffer.data()[i] = static_cast<float>(i % 13) * 0.01f - 0.05f;
  return buffer;
}

void Measure(int outputs, int inputs, int batch, const char* what) {
  const nn::LaneKernels& kernels = nn::LaneKernelsFor(Isa::kAvx512);
  const nn::FloatBuffer weight = Filled(outputs, inputs);
  const nn::FloatBuffer input = Filled(batch, inputs);
  nn::FloatBuffer output = Filled(batch, outputs);
  const double peak = CorePeakGflops();
  const auto print = [&](const char* who, double seconds) {
    const double gflops = 2e-9 * outputs * inputs * batch / seconds;
    fmt::print(R"({{"bench": "dense_product", "case": "{} {}x{} batch {} {}", "value": {:.4g}, )"
               R"("unit": "GFLOP/s", "limit": {:.4g}, "of_limit": {:.3f}}})"
               "\n",
               what, outputs, inputs, batch, who, gflops, peak, gflops / peak);
  };
  print("lanes", BestSeconds([&] {
          kernels.multiply({.rows = outputs,
                            .blocks = batch / kLanes,
                            .depth = inputs,
                            .a = weight.data(),
                            .a_row = inputs,
                            .a_depth = 1,
                            .b = input.data(),
                            .b_block = ptrdiff_t{inputs} * kLanes,
                            .b_depth = kLanes,
                            .c = output.data(),
                            .c_block = ptrdiff_t{outputs} * kLanes,
                            .c_row = kLanes});
        }));
  print("eigen", BestSeconds([&] {
          EigenProduct(input.data(), weight.data(), output.data(), batch, inputs, outputs);
        }));
}

}  // namespace
}  // namespace dadrl::bench

int main(int argc, char** argv) {
  using dadrl::bench::Measure;
  if (dadrl::bench::HelpAsked(argc, argv, "dense_product: our dense product beside Eigen's\n")) return 0;
  if (dadrl::ActiveIsa() != dadrl::Isa::kAvx512) return 0;
  Measure(224, 56, 448, "lstm step");
  Measure(256, 256, 64, "hidden");
  Measure(256, 256, 256, "hidden");
  Measure(128, 256, 64, "encoder output");
  Measure(56, 56, 64, "attention");
}
