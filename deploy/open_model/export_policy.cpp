#include "deploy/open_model/export_policy.h"

#include <nlohmann/json.hpp>

#include "common/config/config_yaml.h"
#include "common/io/atomic_file.h"
#include "common/io/npy.h"
#include "common/model/networks.h"

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

// The network's tensors as files, and its part of the index.
Result<Json> ExportNetwork(const std::string& network, const nn::ParamLayout& layout,
                           std::span<const float> parameters, const std::filesystem::path& directory) {
  std::error_code failed;
  std::filesystem::create_directory(directory / network, failed);  // the first write says if it is not there
  Json tensors = Json::array();
  for (const nn::TensorInfo& tensor : layout.tensors()) {
    const std::string file = fmt::format("{}/{}.npy", network, tensor.name);
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
          {"observation", {{"vehicles", spec.vehicles}, {"history", spec.history}}},
          {"model",
           {{"stae", model.stae},
            {"context", model.context},
            {"critic_layer_norm", model.critic_layer_norm},
            {"layer_norm_epsilon", nn::kLayerNormEpsilon},
            {"log_std_min", model.log_std_min},
            {"log_std_max", model.log_std_max}}},
          {"config", "config.yaml"}};
}

}  // namespace

Status ExportPolicy(const PolicyFile& policy, const std::filesystem::path& source,
                    const std::filesystem::path& directory) {
  const DrivingShape spec = DrivingShape::From(policy.config.observation);
  const PolicyNetwork policy_network(spec, policy.config.model);
  const CriticNetwork critic_network(spec, policy.config.model);
  DADRL_RETURN_IF_ERROR(
      CheckLayout(policy.policy(), source, policy_network.layout.hash(), policy_network.layout.size()));
  const StoredNetwork* critic = policy.Find(kCriticNetwork);
  if (critic != nullptr) {
    DADRL_RETURN_IF_ERROR(
        CheckLayout(*critic, source, critic_network.layout.hash(), critic_network.layout.size()));
  }
  DADRL_RETURN_IF_ERROR(MakeEmptyFolder(directory));
  Json index = Index(policy, source);
  DADRL_ASSIGN_OR_RETURN(index["networks"]["policy"], ExportNetwork("policy", policy_network.layout,
                                                                    policy.policy().parameters, directory));
  if (critic != nullptr) {
    DADRL_ASSIGN_OR_RETURN(index["networks"]["critic"],
                           ExportNetwork("critic", critic_network.layout, critic->parameters, directory));
  }
  const std::string config = ToYaml(policy.config, false);
  DADRL_RETURN_IF_ERROR(WriteFileAtomically(directory / "config.yaml", std::string_view(config)));
  return WriteFileAtomically(directory / "index.json", std::string_view(index.dump(2) + "\n"));
}

}  // namespace dadrl
