// Policy files: what is taken is finite and no longer than its file.
#include "common/model/policy_file.h"

#include <cmath>
#include <vector>

#include "common/config/config_yaml.h"
#include "common/io/read_file.h"
#include "tests/fuzz/outside_text.h"

namespace dadrl::fuzz {
namespace {

Bytes FileOf(const std::string& config_yaml) {
  const std::vector<float> parameters(9, 0.5f);
  const auto path = Folder() / "seed";
  Require(SavePolicy(path, {.layout_hash = 7,
                            .policy_version = 3,
                            .updates = 100,
                            .config_yaml = config_yaml,
                            .parameters = parameters,
                            .critic = parameters})
              .has_value());
  return AskMended(ReadFile(path, 1 << 20).value());
}

}  // namespace

const int kMutants = 20000;

bool Check(std::span<std::byte> input) {
  const std::span<const std::byte> bytes = MendedIfAsked(input);
  const auto policy = LoadPolicy(Written("policy", bytes));
  if (!Accepted(policy)) return false;
  for (const std::vector<float>* values : {&policy->parameters, &policy->critic}) {
    Require(values->size() * sizeof(float) <= bytes.size());
    for (const float value : *values) Require(std::isfinite(value));
  }
  return true;
}

Seeds MakeSeeds() {
  Seeds seeds{
      .accepted = {FileOf(ToYaml(Config{}, false)), FileOf("")},
      .refused = {FileOf("task: &t\n  reward: *t\n"), FileOf(Repeated("[", 3000)), AsBytes("DADRLPOL")}};
  Bytes shorter = FileOf("");
  shorter.resize(40);
  seeds.refused.push_back(shorter);
  return seeds;
}

}  // namespace dadrl::fuzz
