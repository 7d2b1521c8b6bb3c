// `dadrl scenario new NAME`: a folder that can be trained on, from a road network.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

#include "common/util/result.h"

namespace dadrl {

struct NewScenarioOptions {
  std::string name;
  std::string net;  // one of net and osm
  std::string osm;
  std::string from;  // edges
  std::string to;
  std::string into;  // the folder of scenarios; empty: $DADRL_SCENARIOS, else "scenarios"
  bool left_hand = false;

  void AddTo(CLI::App& app);
};

// Makes INTO/NAME whole or not at all, checks it, and says on standard output what it is and how to go on.
// kInvalidArgument: a name that is no folder's, a folder that is there already, a file that is no road, an
// edge that is not there, no way between; also when the scenario cannot be driven, whose folder stays to be
// mended. kNotFound: a file or netconvert is missing.
Result<int> RunNewScenario(const NewScenarioOptions& options);

}  // namespace dadrl
