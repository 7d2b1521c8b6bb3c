#include "common/model/policy_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string_view>

#include "common/config/config_yaml.h"
#include "common/config/validate.h"
#include "common/io/atomic_file.h"
#include "common/io/byte_io.h"
#include "common/io/checksum.h"
#include "common/io/link_file.h"
#include "common/io/read_file.h"

namespace dadrl {
namespace {

constexpr std::string_view kMagic = "DADRLPOL";
constexpr uint32_t kFormat = 2;
constexpr uint32_t kFormatWithoutCritic = 1;
constexpr std::array<std::string_view, 7> kSections = {"scenario",    "seed",  "traffic",  "task",
                                                       "observation", "model", "algorithm"};
constexpr std::string_view kRemedy = "take another policy file of the run's checkpoints folder";

std::string_view AsText(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

struct Content {
  uint32_t format = 0;
  std::span<const std::byte> bytes;  // between format and checksum
};

// Magic and format come before the checksum, so that a file that never was a policy is called so.
Result<Content> CheckedContent(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  const std::string_view magic = AsText(reader.GetBytes(kMagic.size()));
  const auto format = reader.Get<uint32_t>();
  if (!reader.ok() || magic != kMagic) {
    return Fail(ErrorCode::kCorrupt, "{} is not a policy file: {}", path.string(), kRemedy);
  }
  if (format != kFormat && format != kFormatWithoutCritic) {
    return Fail(ErrorCode::kInvalidArgument,
                "{} is a policy file of format {}, this program reads formats {} and {}: use the program "
                "that wrote it",
                path.string(), format, kFormatWithoutCritic, kFormat);
  }
  constexpr size_t kHead = kMagic.size() + sizeof(uint32_t);
  const size_t length = std::max(bytes.size(), kHead + sizeof(uint64_t)) - sizeof(uint64_t);
  ByteReader tail(bytes.subspan(std::min(length, bytes.size())));
  const auto checksum = tail.Get<uint64_t>();
  if (!tail.ok() || checksum != Xxh3(bytes.first(length))) {
    return Fail(ErrorCode::kCorrupt, "{} is damaged (checksum): {}", path.string(), kRemedy);
  }
  return Content{format, bytes.subspan(kHead, length - kHead)};
}

void PutParameters(ByteWriter& writer, std::span<const float> parameters) {
  writer.Put(static_cast<uint64_t>(parameters.size()));
  writer.PutBytes(std::as_bytes(parameters));
}

std::vector<float> GetParameters(ByteReader& reader) {
  const auto count = reader.Get<uint64_t>();
  // A count that overflows the product must not look small.
  const std::span<const std::byte> bytes =
      reader.GetBytes(count > reader.remaining() ? UINT64_MAX : count * sizeof(float));
  std::vector<float> parameters(bytes.size() / sizeof(float));
  if (!parameters.empty()) std::memcpy(parameters.data(), bytes.data(), bytes.size());
  return parameters;
}

}  // namespace

Status SavePolicy(const std::filesystem::path& path, const PolicyToSave& policy) {
  std::vector<std::byte> bytes;
  bytes.reserve(policy.parameters.size_bytes() + policy.critic.size_bytes() + policy.config_yaml.size() + 64);
  ByteWriter writer(bytes);
  writer.PutBytes(std::as_bytes(std::span(kMagic)));
  writer.Put(kFormat);
  writer.Put(policy.policy_version);
  writer.Put(policy.updates);
  writer.Put(policy.layout_hash);
  writer.PutText(policy.config_yaml);
  PutParameters(writer, policy.parameters);
  PutParameters(writer, policy.critic);
  writer.Put(Xxh3(bytes));
  return WriteFileAtomically(path, bytes);
}

Result<PolicyFile> LoadPolicy(const std::filesystem::path& path) {
  DADRL_ASSIGN_OR_RETURN(const std::vector<std::byte> bytes,
                         ReadFile(FollowLinks(path), kMaxPolicyBytes, Links::kFollow));
  DADRL_ASSIGN_OR_RETURN(const Content content, CheckedContent(path, bytes));
  ByteReader reader(content.bytes);
  PolicyFile policy;
  policy.policy_version = reader.Get<uint32_t>();
  policy.updates = reader.Get<uint64_t>();
  policy.layout_hash = reader.Get<uint64_t>();
  const std::string config_yaml = reader.GetText();
  policy.parameters = GetParameters(reader);
  if (content.format != kFormatWithoutCritic) policy.critic = GetParameters(reader);
  if (!reader.ok() || reader.remaining() != 0) {
    return Fail(ErrorCode::kCorrupt, "{} is damaged (lengths): {}", path.string(), kRemedy);
  }
  DADRL_RETURN_IF_ERROR(ParseYamlSections(config_yaml, path.string(), kSections, policy.config));
  DADRL_RETURN_IF_ERROR(Validate(policy.config));
  for (const std::vector<float>* values : {&policy.parameters, &policy.critic}) {
    const auto bad = std::ranges::find_if_not(*values, [](float value) { return std::isfinite(value); });
    if (bad == values->end()) continue;
    return Fail(ErrorCode::kCorrupt, "{}: {} {} is not finite: {}", path.string(),
                values == &policy.parameters ? "parameter" : "critic parameter", bad - values->begin(),
                kRemedy);
  }
  return policy;
}

Status CheckLayout(const PolicyFile& policy, const std::filesystem::path& path, uint64_t layout_hash,
                   size_t parameter_count) {
  if (policy.layout_hash == layout_hash && policy.parameters.size() == parameter_count) return {};
  return Fail(
      ErrorCode::kInvalidArgument,
      "{} holds networks of another layout ({} parameters, hash {:016x}; this program builds {} with hash "
      "{:016x} from the same configuration): use the program that wrote it",
      path.string(), policy.parameters.size(), policy.layout_hash, parameter_count, layout_hash);
}

}  // namespace dadrl
