#include "proto/evaluation/episode_summary.h"

#include <algorithm>

#include "common/util/enum_array.h"

namespace dadrl {
namespace {

constexpr EnumArray<Outcome, std::string_view, kOutcomes> kNames = {"success", "collision", "off_road",
                                                                    "stagnation"};

}  // namespace

std::string_view OutcomeName(Outcome outcome) { return kNames[outcome]; }

std::optional<Outcome> OutcomeFromName(std::string_view name) {
  const auto it = std::ranges::find(kNames, name);
  if (it == kNames.end()) return std::nullopt;
  return static_cast<Outcome>(it - kNames.begin());
}

}  // namespace dadrl
