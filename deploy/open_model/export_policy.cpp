#include "deploy/open_model/export_policy.h"

#include <nlohmann/json.hpp>

#include "common/config/config_yaml.h"
#include "common/io/atomic_file.h"
#include "common/io/npy.h"
#include "common/model/policy_model.h"
#include "common/model/value_model.h"
#include "common/nn/lanes/lane_kernels.h"

namespace dadrl {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kExportFormat = 1;

Status MakeEmptyFolder(const std::filesystem::path& directory) {
  std::error_code failed;
  std::filesystem::create_directories(directory, failed);
  const bool empty = !failed && std::filesystem::is_empty(directory, failed);
  if (failed) {
    return Fail(ErrorCode::kInternal, "cannot create {}: {}; choose another folder", directory.string(),
                failed.message());
  }
  if (!empty) {
    return Fail(ErrorCode::kInvalidArgument, "{} is not empty: choose a new folder, or remove it first",
                directory.string());
  }
  return {};
}

Result<nn::ParamLayout> LayoutOf(const StoredNetwork& network, const Config& config) {
  const DrivingShape spec = DrivingShape::From(config.observation);
  if (network.name == kPolicyNetwork) {
    DADRL_ASSIGN_OR_RETURN(const auto policy, MakePolicyModel(spec, config.model));
    return policy->layout();
  }
  DADRL_ASSIGN_OR_RETURN(const auto values, MakeValueModel(network.name, spec, config.model));
  return values->layout();
}

// The network's tensors as files, and its part of the index.
Result<Json> ExportNetwork(const StoredNetwork& network, const nn::ParamLayout& layout,
                           const std::filesystem::path& directory) {
  const std::span<const float> parameters = network.parameters;
  std::error_code failed;  // the first write says if the folder is not there
  std::filesystem::create_directory(directory / network.name, failed);
  Json tensors = Json::array();
  for (const nn::TensorInfo& tensor : layout.tensors()) {
    const std::string file = fmt::format("{}/{}.npy", network.name, tensor.name);
    const std::vector<size_t> shape(tensor.shape.begin(), tensor.shape.end());
    DADRL_RETURN_IF_ERROR(
        WriteNpy<float>(directory / file, shape, parameters.subspan(tensor.offset, tensor.size)));
    tensors.push_back({{"name", tensor.name}, {"shape", shape}, {"file", file}});
  }
  return tensors;
}

Json Index(const PolicyFile& policy, const std::filesystem::path& source) {
  const DrivingShape spec = DrivingShape::From(policy.config.observation);
  const ModelConfig& model = policy.config.model;
  return {{"format", kExportFormat},
          {"source", source.filename().string()},
          {"scenario", policy.config.scenario},
          {"updates", policy.updates},
          {"policy_version", policy.policy_version},
          {"observation",
           {{"vehicles", spec.vehicles}, {"history", spec.history}, {"polylines", spec.polylines}}},
          {"model",
           {{"policy", model.policy},
            {"stae", model.stae},
            {"context", model.context},
            {"scene", model.scene},
            {"critic_layer_norm", model.critic_layer_norm},
            {"layer_norm_epsilon", nn::kLayerNormEpsilon},
            {"log_std_min", model.log_std_min},
            {"log_std_max", model.log_std_max}}},
          {"config", "config.yaml"}};
}

}  // namespace

Status ExportPolicy(const PolicyFile& policy, const std::filesystem::path& source,
                    const std::filesystem::path& directory) {
  std::vector<nn::ParamLayout> layouts;
  for (const StoredNetwork& network : policy.networks) {
    const Result<nn::ParamLayout> layout = LayoutOf(network, policy.config);
    if (!layout) return Fail(layout.error().code, "{}: {}", source.string(), layout.error().message);
    DADRL_RETURN_IF_ERROR(CheckLayout(network, source, layout->hash(), layout->size()));
    layouts.push_back(*layout);
  }
  DADRL_RETURN_IF_ERROR(MakeEmptyFolder(directory));
  Json index = Index(policy, source);
  for (size_t i = 0; i < layouts.size(); ++i) {
    DADRL_ASSIGN_OR_RETURN(index["networks"][policy.networks[i].name],
                           ExportNetwork(policy.networks[i], layouts[i], directory));
  }
  const std::string config = ToYaml(policy.config, false);
  DADRL_RETURN_IF_ERROR(WriteFileAtomically(directory / "config.yaml", std::string_view(config)));
  return WriteFileAtomically(directory / "index.json", std::string_view(index.dump(2) + "\n"));
}

}  // namespace dadrl
