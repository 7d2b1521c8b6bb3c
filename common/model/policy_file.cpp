#include "common/model/policy_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/config/config_yaml.h"
#include "common/config/validate.h"
#include "common/io/atomic_file.h"
#include "common/io/byte_io.h"
#include "common/io/checksum.h"
#include "common/io/file_reader.h"
#include "common/io/link_file.h"

namespace dadrl {
namespace {

constexpr uint32_t kPolicyAlone = 1;  // 2: policy and critics without names
constexpr uint32_t kNamed = 3;
constexpr std::array<std::string_view, 7> kSections = {"scenario",    "seed",  "traffic",  "task",
                                                       "observation", "model", "algorithm"};
constexpr std::string_view kRemedy = "take another policy file of the run's checkpoints folder";
constexpr FileKind kKind{.magic = "DADRLPOL",
                         .name = "a policy file",
                         .oldest = kPolicyAlone,
                         .format = kNamed,
                         .remedy = kRemedy};

constexpr uint32_t kMostNetworks = 64;

// The names become folders of an export.
bool IsNetworkName(std::string_view name) {
  constexpr size_t kLongest = 64;
  return !name.empty() && name.size() <= kLongest && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

std::vector<StoredNetwork> ReadNetworks(FileReader& reader) {
  std::vector<StoredNetwork> networks;
  const auto count = reader.Get<uint32_t>();
  if (count > kMostNetworks) return networks;  // what is left over is refused
  for (uint32_t i = 0; i < count && reader.ok(); ++i) {
    std::string name = reader.GetText();
    const auto layout_hash = reader.Get<uint64_t>();
    networks.push_back({std::move(name), layout_hash, reader.GetVector<float>()});
  }
  return networks;
}

std::vector<StoredNetwork> ReadUnnamedNetworks(FileReader& reader, uint32_t format, uint64_t layout_hash) {
  std::vector<StoredNetwork> networks;
  networks.push_back({std::string(kPolicyNetwork), layout_hash, reader.GetVector<float>()});
  if (format == kPolicyAlone) return networks;
  StoredNetwork critic{std::string(kCriticNetwork), 0, reader.GetVector<float>()};
  if (!critic.parameters.empty()) networks.push_back(std::move(critic));
  return networks;
}

Status CheckNetworks(const std::vector<StoredNetwork>& networks, const std::filesystem::path& path) {
  if (networks.empty() || networks.front().name != kPolicyNetwork) {
    return Fail(ErrorCode::kCorrupt, "{}: its first network is not '{}': {}", path.string(), kPolicyNetwork,
                kRemedy);
  }
  for (auto network = networks.begin(); network != networks.end(); ++network) {
    if (!IsNetworkName(network->name) ||
        std::ranges::find(networks.begin(), network, network->name, &StoredNetwork::name) != network) {
      return Fail(ErrorCode::kCorrupt, "{}: the name of network {} is none, or another's: {}", path.string(),
                  network - networks.begin(), kRemedy);
    }
    const std::vector<float>& values = network->parameters;
    const auto bad = std::ranges::find_if_not(values, [](float value) { return std::isfinite(value); });
    if (bad == values.end()) continue;
    return Fail(ErrorCode::kCorrupt, "{}: parameter {} of network '{}' is not finite: {}", path.string(),
                bad - values.begin(), network->name, kRemedy);
  }
  return {};
}

}  // namespace

const StoredNetwork* PolicyFile::Find(std::string_view name) const {
  const auto found = std::ranges::find(networks, name, &StoredNetwork::name);
  return found == networks.end() ? nullptr : &*found;
}

Status SavePolicy(const std::filesystem::path& path, const PolicyToSave& policy) {
  std::vector<std::byte> bytes;
  size_t length = policy.config_yaml.size() + 64;
  for (const NamedNetwork& network : policy.networks) length += network.parameters.size_bytes() + 128;
  bytes.reserve(length);
  ByteWriter writer(bytes);
  kKind.PutHead(writer);
  writer.Put(policy.policy_version);
  writer.Put(policy.updates);
  writer.PutText(policy.config_yaml);
  writer.Put<uint32_t>(policy.networks.size());
  for (const NamedNetwork& network : policy.networks) {
    writer.PutText(network.name);
    writer.Put(network.layout_hash);
    writer.Put(uint64_t{network.parameters.size()});
    writer.PutBytes(std::as_bytes(network.parameters));
  }
  AppendChecksum(bytes);
  return WriteFileAtomically(path, bytes);
}

Result<PolicyFile> LoadPolicy(const std::filesystem::path& path) {
  DADRL_ASSIGN_OR_RETURN(FileReader reader,
                         FileReader::Open(FollowLinks(path), kMaxPolicyBytes, Links::kFollow));
  DADRL_ASSIGN_OR_RETURN(const uint32_t format, reader.GetHead(kKind));
  PolicyFile policy;
  policy.policy_version = reader.Get<uint32_t>();
  policy.updates = reader.Get<uint64_t>();
  const uint64_t policy_hash = format == kNamed ? 0 : reader.Get<uint64_t>();
  const std::string config_yaml = reader.GetText();
  policy.networks =
      format == kNamed ? ReadNetworks(reader) : ReadUnnamedNetworks(reader, format, policy_hash);
  DADRL_RETURN_IF_ERROR(reader.CheckEnd(kRemedy));
  DADRL_RETURN_IF_ERROR(CheckNetworks(policy.networks, path));
  DADRL_RETURN_IF_ERROR(ParseYamlSections(config_yaml, path.string(), kSections, policy.config));
  DADRL_RETURN_IF_ERROR(Validate(policy.config));
  return policy;
}

Status CheckLayout(const StoredNetwork& network, const std::filesystem::path& path, uint64_t layout_hash,
                   size_t parameter_count) {
  const bool same = network.layout_hash == layout_hash || network.layout_hash == 0;
  if (same && network.parameters.size() == parameter_count) return {};
  return Fail(
      ErrorCode::kInvalidArgument,
      "{} holds a network '{}' of another layout ({} parameters, hash {:016x}; this program builds {} with "
      "hash {:016x} from the same configuration): use the program that wrote it",
      path.string(), network.name, network.parameters.size(), network.layout_hash, parameter_count,
      layout_hash);
}

}  // namespace dadrl
