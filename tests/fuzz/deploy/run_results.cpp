// results.json of earlier sessions: what cannot be used is set aside, and what is said of the rest are
// numbers.
#include "deploy/local/run_results.h"

#include <cmath>

#include "tests/fuzz/outside_text.h"

namespace dadrl::fuzz {
namespace {

// None.
EpisodeLog& Episodes() {
  static EpisodeLog episodes = EpisodeLog::Open(Folder() / "episodes.csv", Folder() / "logs").value();
  return episodes;
}

}  // namespace

const int kMutants = 5000;

bool Check(std::span<std::byte> input) {
  const auto path = Written("results.json", input);
  Require(LastEvaluation(path).size() < 1000);
  RunResults results = RunResults::Load(path, Config{});
  Require(std::isfinite(results.earlier_s()) && results.earlier_s() >= 0.0);
  results.Update("running", 1.0, TrainedSoFar{.updates = 3}, Episodes());
  Require(results.Text().ends_with("}\n"));
  return !std::filesystem::remove(path.string() + ".corrupt");
}

Seeds MakeSeeds() {
  return {.accepted =
              {AsBytes(R"({"state": "finished", "training_s": 12.5, "env_steps": 1000, "training_episodes": 9,
        "evaluations": [{"updates": 5, "success": 0.5, "collision": 0.25, "episodes": 4}]})"),
               AsBytes(R"({"training_s": -1e308, "env_steps": -5, "evaluations": {"a": 1}, "final": [1]})")},
          .refused = BadJson()};
}

}  // namespace dadrl::fuzz
