// Scenario files: whatever they say, nothing outside the folder of scenarios is read.
#include "actor/sim/scenario.h"

#include <cmath>

#include "tests/fuzz/outside_text.h"

namespace dadrl::fuzz {
namespace {

constexpr std::string_view kGood = R"(warm_up_s: 2
ego: {lanes: [a_0, b_1], start_offset_m: 4.5}
traffic:
  driver_types: 3
  flows:
    - {edges: [a, b], depart_lane: 1, arrival_lane: 2, depart: lane_end, arrival: random}
profiles:
  calibrated: {driver: {emergencyDecel: 5.0}, sumo: {lanechange.duration: 3}}
  plain: {}
)";

}  // namespace

const int kMutants = 5000;

bool Check(std::span<std::byte> input) {
  static const auto network = Written("scenarios/mine/network.net.xml", {});
  Written("scenarios/mine/scenario.yaml", input);
  const auto scenario = LoadScenario("mine", Folder() / "scenarios");
  if (!Accepted(scenario)) return false;
  Require(std::isfinite(scenario->warm_up_s) && std::isfinite(scenario->ego_start_offset_m));
  Require(scenario->driver_types >= 1 && !scenario->ego_lanes.empty());
  Require(scenario->network == network);
  return true;
}

Seeds MakeSeeds() {
  Seeds seeds{.accepted = {AsBytes(kGood)}, .refused = BadYaml()};
  seeds.refused.push_back(AsBytes("network: ../../etc\n" + std::string(kGood)));
  for (const std::string_view option : {"tripinfo-output", "log", "\"seed\"", "save-state.prefix"}) {
    std::string writing(kGood);
    writing.replace(writing.find("lanechange.duration"), std::string_view("lanechange.duration").size(),
                    option);
    seeds.refused.push_back(AsBytes(writing));
  }
  return seeds;
}

}  // namespace dadrl::fuzz
