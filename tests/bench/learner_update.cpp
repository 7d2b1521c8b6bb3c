// Speed of whole SAC updates, from a batch in memory to updated weights, beside the cores' multiply-add peak.
//
//   learner_update [CASE...]      e.g. "separate b64 t1" "shared b256 t2": encoders, batch, threads; without:
//   all
//
// Prints JSON lines: updates/s against what the peak would allow, GFLOP/s against the peak. Medians over a
// few seconds a case; the peak is the best measured before, between and after. DADRL_ISA chooses the
// instruction set.
#include <fmt/core.h>

#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "learner/algorithms/registry.h"
#include "tests/bench/core_peak.h"
#include "tests/bench/help.h"
#include "tests/bench/network_flops.h"
#include "tests/bench/observations.h"

namespace dadrl::bench {
namespace {

constexpr double kCaseSeconds = 2.0;

void Print(const std::string& name, double value, const char* unit, double limit) {
  fmt::print(R"({{"bench": "learner_update", "case": "{}", "value": {:.4g}, "unit": "{}", "limit": {:.4g}, )"
             R"("of_limit": {:.3f}}})"
             "\n",
             name, value, unit, limit, limit > 0.0 ? value / limit : 0.0);
}

struct Case {
  EncoderSharing encoders;
  int batch_size;
  int threads;

  std::string name() const {
    return fmt::format("{} b{} t{}", encoders == EncoderSharing::kShared ? "shared" : "separate", batch_size,
                       threads);
  }
};

bool Measure(const Case& c) {
  Config config;
  config.model.encoders = c.encoders;
  config.algorithm.batch_size = c.batch_size;
  config.learner.threads = c.threads;
  const auto algorithm = MakeAlgorithm(config);
  if (!algorithm) {
    fmt::print(stderr, "error: {}\n", algorithm.error().message);
    return false;
  }
  const TrajectoryBatch batch = RoadBatch(DrivingShape::From(config.observation), c.batch_size);
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
  const double flops = NetworkWork::UpdateFlops(c.encoders) * c.batch_size;
  Print(c.name(), 1.0 / median, "updates/s", peak * c.threads * 1e9 / flops);
  Print(c.name(), flops / median * 1e-9, "GFLOP/s", peak * c.threads);
  return true;
}

std::vector<Case> AllCases() {
  std::vector<Case> cases;
  for (const EncoderSharing encoders : {EncoderSharing::kSeparate, EncoderSharing::kShared}) {
    for (const int batch_size : {64, 256}) {
      for (const int threads : {1, 2}) cases.push_back({encoders, batch_size, threads});
    }
  }
  return cases;
}

int Main(std::span<char*> names) {
  const std::vector<Case> all = AllCases();
  std::vector<Case> chosen;
  for (const std::string name : names) {
    const auto found = std::ranges::find(all, name, &Case::name);
    if (found == all.end()) {
      fmt::print(stderr, "error: no case '{}'; there is for example '{}'\n", name, all.front().name());
      return 2;
    }
    chosen.push_back(*found);
  }
  return std::ranges::all_of(names.empty() ? all : chosen, Measure) ? 0 : 1;
}

}  // namespace
}  // namespace dadrl::bench

int main(int argc, char** argv) {
  if (dadrl::bench::HelpAsked(argc, argv,
                              "learner_update [CASE...]: whole SAC updates; a case is \"separate b64 t1\": "
                              "encoders, batch,\nthreads\n")) {
    return 0;
  }
  return dadrl::bench::Main(std::span(argv, static_cast<size_t>(argc)).subspan(1));
}
