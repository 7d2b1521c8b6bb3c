#include "deploy/local/shipped_policies.h"

#include <algorithm>
#include <system_error>

#include "common/config/config_schema.h"
#include "common/io/json_text.h"
#include "common/io/read_file.h"
#include "common/util/environment.h"
#include "deploy/local/executables.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPrefix = "pretrained:";
constexpr uint64_t kMaxRecordBytes = uint64_t{1} << 20;

nlohmann::ordered_json ReadRecord(const fs::path& file) {
  const auto text = ReadTextFile(file, kMaxRecordBytes, Links::kFollow);
  auto record =
      text ? ParseJson(*text, file.string()).value_or(nlohmann::ordered_json()) : nlohmann::ordered_json();
  return record.is_object() ? record : nlohmann::ordered_json::object();
}

}  // namespace

fs::path PolicyFolder() {
  if (const auto folder = FromEnvironment(kPoliciesVariable)) return *folder;
  return SharedFolder() / "policies";
}

std::vector<ShippedPolicy> ShippedPolicies() {
  std::vector<ShippedPolicy> policies;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(PolicyFolder(), error)) {
    fs::path file = entry.path();
    if (file.extension() != ".dadrl") continue;
    policies.push_back({file.stem(), file, ReadRecord(fs::path(file).replace_extension(".json"))});
  }
  std::ranges::sort(policies, {}, &ShippedPolicy::name);
  return policies;
}

Result<std::string> ResolvePolicy(const std::string& policy) {
  if (!policy.starts_with(kPrefix)) return policy;
  const std::string name = policy.substr(kPrefix.size());
  const std::vector<ShippedPolicy> policies = ShippedPolicies();
  if (policies.empty()) {
    return Fail(ErrorCode::kInvalidArgument, "{}: no policy ships in {}; {}", policy, PolicyFolder().string(),
                FolderRemedy(kPoliciesVariable, "train one or set DADRL_POLICIES"));
  }
  std::vector<std::string> names;
  for (const ShippedPolicy& shipped : policies) {
    if (shipped.name == name) return shipped.file.string();
    names.push_back(shipped.name);
  }
  return Fail(ErrorCode::kInvalidArgument,
              "no shipped policy is called '{}'; the nearest is '{}' (there are: {})", name,
              NearestName(name, names), fmt::join(names, ", "));
}

}  // namespace dadrl
