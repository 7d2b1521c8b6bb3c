#include "learner/list_algorithms.h"

#include <nlohmann/json.hpp>

#include "learner/algorithms/registry.h"

namespace dadrl {
namespace {

using Json = nlohmann::ordered_json;

Json Described(const AlgorithmEntry& entry) {
  Config config;
  config.algorithm.name = entry.name;
  const AlgorithmSpec spec = entry.spec(config);
  Json scalars = Json::array();
  for (const ScalarSpec& scalar : spec.scalars) scalars.push_back(scalar.name);
  return {{"name", entry.name},
          {"description", entry.description},
          {"scalars", scalars},
          {"gives_priorities", spec.gives_priorities},
          {"acts_from_start", spec.acts_from_start}};
}

}  // namespace

std::string AlgorithmList(bool json) {
  std::string lines;
  Json rows = Json::array();
  for (const AlgorithmEntry& entry : Algorithms()) {
    lines += fmt::format("{:<8} {}\n", entry.name, entry.description);
    rows.push_back(Described(entry));
  }
  return json ? Json{{"algorithms", rows}}.dump() + "\n" : lines;
}

}  // namespace dadrl
