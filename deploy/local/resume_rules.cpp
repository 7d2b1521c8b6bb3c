#include "deploy/local/resume_rules.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "common/config/config_schema.h"

namespace dadrl {
namespace {

// A key or, ending in a dot, a section. What the weights, the optimiser or stored frames were made with.
constexpr std::array<std::string_view, 9> kFixed = {
    "scenario", "seed",           "traffic.",        "task.",        "observation.",
    "model.",   "algorithm.name", "algorithm.gamma", "replay.shards"};

bool IsFixed(std::string_view key) {
  return std::any_of(kFixed.begin(), kFixed.end(), [&](std::string_view fixed) {
    return fixed.back() == '.' ? key.starts_with(fixed) : key == fixed;
  });
}

}  // namespace

Status CheckResumable(const Config& run, const Config& wanted) {
  Config before = run;
  Config after = wanted;
  const auto old_fields = SchemaOf(before);
  const auto new_fields = SchemaOf(after);
  for (size_t i = 0; i < old_fields.size(); ++i) {
    const std::string was = FormatValue(old_fields[i]);
    const std::string is = FormatValue(new_fields[i]);
    if (was == is || !IsFixed(old_fields[i].key)) continue;
    return Fail(
        ErrorCode::kInvalidArgument,
        "--resume cannot change {} from {} to {}: the run's weights and experience were made with the "
        "former; start a new run instead",
        old_fields[i].key, was, is);
  }
  return {};
}

}  // namespace dadrl
