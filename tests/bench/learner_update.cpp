// Speed of whole SAC updates, from a batch in memory to updated weights, beside the cores' multiply-add peak.
//
// Prints JSON lines: updates/s against what the peak would allow, GFLOP/s against the peak. Medians over a
// few seconds a case; the peak is the best measured before, between and after. DADRL_ISA chooses the
// instruction set.
#include <fmt/core.h>

#include <string>

#include "learner/algorithms/algorithm.h"
#include "tests/bench/core_peak.h"
#include "tests/bench/network_flops.h"
#include "tests/bench/observations.h"

namespace dadrl::bench {
namespace {

constexpr double kCaseSeconds = 3.0;

void Print(const std::string& name, double value, const char* unit, double limit) {
  fmt::print(R"({{"bench": "learner_update", "case": "{}", "value": {:.4g}, "unit": "{}", "limit": {:.4g}, )"
             R"("of_limit": {:.3f}}})"
             "\n",
             name, value, unit, limit, limit > 0.0 ? value / limit : 0.0);
}

bool Measure(EncoderSharing encoders, int batch_size, int threads) {
  Config config;
  config.model.encoders = encoders;
  config.algorithm.batch_size = batch_size;
  config.learner.threads = threads;
  const auto algorithm = MakeAlgorithm(config);
  if (!algorithm) {
    fmt::print(stderr, "error: {}\n", algorithm.error().message);
    return false;
  }
  const TransitionBatch batch = RoadBatch(ObservationSpec::From(config.observation), batch_size);
  double peak = 0.0;
  std::vector<double> seconds;
  const double end = Seconds() + kCaseSeconds;
  for (int round = 0; Seconds() < end; ++round) {
    if (round % 20 == 0) peak = std::max(peak, CorePeakGflops());
    const double start = Seconds();
    const auto stats = (*algorithm)->Update(batch);
    if (round >= 2) seconds.push_back(Seconds() - start);
    if (!stats) {
      fmt::print(stderr, "error: {}\n", stats.error().message);
      return false;
    }
  }
  const double median = Quantile(seconds, 0.5);
  const double flops = NetworkWork::UpdateFlops(encoders) * batch_size;
  const std::string name = fmt::format(
      "{} b{} t{}", encoders == EncoderSharing::kShared ? "shared" : "separate", batch_size, threads);
  Print(name, 1.0 / median, "updates/s", peak * threads * 1e9 / flops);
  Print(name, flops / median * 1e-9, "GFLOP/s", peak * threads);
  return true;
}

}  // namespace
}  // namespace dadrl::bench

int main() {
  using dadrl::EncoderSharing;
  for (const EncoderSharing encoders : {EncoderSharing::kSeparate, EncoderSharing::kShared}) {
    for (const int batch_size : {64, 256}) {
      for (const int threads : {1, 2}) {
        if (!dadrl::bench::Measure(encoders, batch_size, threads)) return 1;
      }
    }
  }
}
