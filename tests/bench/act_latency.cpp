// Latency of the acting policy on one observation, deterministic, beside what the core's peak would allow.
//
// Prints JSON lines: median and 99th percentile in microseconds; of_limit is limit / value. An absent vehicle
// costs nothing, so the full road is the worst case.
#include <fmt/core.h>

#include <string>

#include "common/model/policy_model.h"
#include "tests/bench/core_peak.h"
#include "tests/bench/help.h"
#include "tests/bench/network_flops.h"
#include "tests/bench/observations.h"

namespace dadrl::bench {
namespace {

void Print(const std::string& name, double value_us, double limit_us) {
  fmt::print(R"({{"bench": "act_latency", "case": "{}", "value": {:.4g}, "unit": "us", "limit": {:.4g}, )"
             R"("of_limit": {:.3f}}})"
             "\n",
             name, value_us, limit_us, limit_us / value_us);
}

bool Measure(int present, const std::string& name) {
  constexpr int kObservations = 32;
  constexpr int kRepetitions = 8000;
  const DrivingShape spec;
  const ModelConfig model;
  const std::unique_ptr<PolicyModel> policy = MakePolicyModel(spec, model).value();
  std::vector<float> parameters(policy->layout().size());
  policy->layout().Initialize(1, parameters);
  if (const Status status = policy->Load(parameters); !status) {
    fmt::print(stderr, "error: {}\n", status.error().message);
    return false;
  }
  std::vector<Observation> observations(kObservations, Observation(spec));
  Random random(1);
  for (Observation& o : observations) {
    FillRoad(spec, random, present, VehiclesOf(o).data(), EgoOf(o).data(), ContextOf(o).data());
  }
  double peak = CorePeakGflops();
  std::vector<double> seconds;
  for (int i = 0; i < kRepetitions; ++i) {
    const double start = Seconds();
    policy->Act(observations[static_cast<size_t>(i % kObservations)], nullptr);
    seconds.push_back(Seconds() - start);
  }
  peak = std::max(peak, CorePeakGflops());
  const double limit = peak > 0.0 ? NetworkWork::kActFlops / peak * 1e-3 : 0.0;
  Print(name + " median", Quantile(seconds, 0.5) * 1e6, limit);
  Print(name + " p99", Quantile(seconds, 0.99) * 1e6, limit);
  return true;
}

}  // namespace
}  // namespace dadrl::bench

int main(int argc, char** argv) {
  using dadrl::bench::Measure;
  if (dadrl::bench::HelpAsked(argc, argv, "act_latency: latency of the acting policy on one observation\n")) {
    return 0;
  }
  return Measure(6, "six vehicles") && Measure(2, "two vehicles") ? 0 : 1;
}
