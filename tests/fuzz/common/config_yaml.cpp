// Configurations: what is taken is within its ranges, and is written as it is read.
#include "common/config/config_yaml.h"

#include "common/config/config_schema.h"
#include "tests/fuzz/outside_text.h"

namespace dadrl::fuzz {

const int kMutants = 4000;

bool Check(std::span<std::byte> input) {
  Config config;
  if (!Accepted(ParseYaml(AsText(input), "config", config))) return false;
  for (const ConfigField& field : SchemaOf(config)) {
    if (std::holds_alternative<std::string*>(field.target)) continue;
    Require(AssignValue(field, FormatValue(field)).has_value());
  }
  Config again;
  Require(ParseYaml(ToYaml(config, false), "again", again).has_value());
  Require(ToYaml(again, false) == ToYaml(config, false));
  return true;
}

Seeds MakeSeeds() {
  return {.accepted = {AsBytes(ToYaml(Config{}, false)), AsBytes(""),
                       AsBytes("task: {max_steps: 30, reward: {goal: 2}}")},
          .refused = BadYaml()};
}

}  // namespace dadrl::fuzz
