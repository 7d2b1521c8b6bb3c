// Policy files: what is taken is finite and no longer than its file.
#include "common/model/policy_file.h"

#include <cmath>
#include <vector>

#include "common/config/config_yaml.h"
#include "common/io/byte_io.h"
#include "common/io/checksum.h"
#include "common/io/read_file.h"
#include "tests/fuzz/outside_text.h"

namespace dadrl::fuzz {
namespace {

Bytes FileOf(const std::string& config_yaml, std::string_view second_network = "critic") {
  const std::vector<float> parameters(9, 0.5f);
  const auto path = Folder() / "seed";
  Require(SavePolicy(path, {.policy_version = 3,
                            .updates = 100,
                            .config_yaml = config_yaml,
                            .networks = {{"policy", 7, parameters}, {second_network, 8, parameters}}})
              .has_value());
  return AskMended(ReadFile(path, 1 << 20).value());
}

// Formats 1 and 2.
Bytes OldFileOf(uint32_t format) {
  const std::vector<float> parameters(9, 0.5f);
  std::vector<std::byte> bytes;
  ByteWriter writer(bytes);
  writer.PutBytes(AsBytes("DADRLPOL"));
  writer.Put(format);
  writer.Put(uint32_t{3});
  writer.Put(uint64_t{100});
  writer.Put(uint64_t{7});
  writer.PutText("seed: 1\n");
  for (uint32_t network = 0; network < format; ++network) {
    writer.Put(uint64_t{parameters.size()});
    writer.PutBytes(std::as_bytes(std::span(parameters)));
  }
  writer.Put(Xxh3(bytes));
  return AskMended(bytes);
}

}  // namespace

const int kMutants = 20000;

bool Check(std::span<std::byte> input) {
  const std::span<const std::byte> bytes = MendedIfAsked(input);
  const auto policy = LoadPolicy(Written("policy", bytes));
  if (!Accepted(policy)) return false;
  size_t total = 0;
  for (const StoredNetwork& network : policy->networks) {
    total += network.name.size() + network.parameters.size() * sizeof(float);
    for (const float value : network.parameters) Require(std::isfinite(value));
    Require(policy->Find(network.name) == &network);
    Require(network.name.find_first_of("./") == std::string::npos);
  }
  Require(policy->policy().name == "policy" && total <= bytes.size() + 12);  // old names are not in the file
  return true;
}

Seeds MakeSeeds() {
  Seeds seeds{.accepted = {FileOf(ToYaml(Config{}, false)), FileOf(""), OldFileOf(1), OldFileOf(2)},
              .refused = {FileOf("task: &t\n  reward: *t\n"), FileOf(Repeated("[", 3000)),
                          FileOf("", "../up"), FileOf("", "policy"), AsBytes("DADRLPOL")}};
  Bytes shorter = FileOf("");
  shorter.resize(40);
  seeds.refused.push_back(shorter);
  return seeds;
}

}  // namespace dadrl::fuzz
