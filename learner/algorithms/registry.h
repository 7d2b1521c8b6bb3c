// Every learning algorithm by name: the one place that a new one is added to.
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "common/config/config.h"
#include "common/util/result.h"
#include "learner/algorithms/algorithm.h"

namespace dadrl {

struct AlgorithmEntry {
  std::string_view name;         // algorithm.name; its preset is deploy/config/algorithms/NAME.yaml
  std::string_view description;  // what it is, for users
  AlgorithmSpec (*spec)(const Config& config);
  std::unique_ptr<Algorithm> (*make)(const Config& config);
};

std::span<const AlgorithmEntry> Algorithms();

// kInvalidArgument with the nearest name and all of them when there is none of this name.
Result<const AlgorithmEntry*> FindAlgorithm(std::string_view name);

// kInvalidArgument with key, value and remedy when `config` asks for what an algorithm of this `spec` does
// not give, or does not give what it needs.
Status CheckNeeds(const Config& config, const AlgorithmSpec& spec);

// kInvalidArgument with both named when `trained`, the published policy of an algorithm, is not the network
// that model.policy acts with: actors would refuse it for ever.
Status CheckTrainsPolicy(const Config& config, const NamedNetwork& trained);

// That of algorithm.name; errors of all of the above.
Result<std::unique_ptr<Algorithm>> MakeAlgorithm(const Config& config);

}  // namespace dadrl
