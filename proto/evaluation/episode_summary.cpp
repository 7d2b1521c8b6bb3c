#include "proto/evaluation/episode_summary.h"

#include <algorithm>
#include <array>

namespace dadrl {
namespace {

constexpr std::array<std::string_view, 4> kNames = {"success", "collision", "off_road", "stagnation"};

}  // namespace

std::string_view OutcomeName(Outcome outcome) { return kNames[static_cast<size_t>(outcome)]; }

std::optional<Outcome> OutcomeFromName(std::string_view name) {
  const auto it = std::ranges::find(kNames, name);
  if (it == kNames.end()) return std::nullopt;
  return static_cast<Outcome>(it - kNames.begin());
}

}  // namespace dadrl
