#include "common/model/value_model.h"

#include <algorithm>
#include <array>

#include "common/model/critic_values.h"
#include "common/model/named_network.h"
#include "common/util/shown.h"

namespace dadrl {
namespace {

struct Entry {
  std::string_view network;
  Result<std::unique_ptr<ValueModel>> (*make)(const StepSpec&, const ModelConfig&);
};

constexpr std::array kValueModels = {Entry{kCriticNetwork, MakeCriticValues}};

}  // namespace

Result<std::unique_ptr<ValueModel>> MakeValueModel(std::string_view network, const StepSpec& spec,
                                                   const ModelConfig& model) {
  const auto* entry = std::ranges::find(kValueModels, network, &Entry::network);
  if (entry != kValueModels.end()) return entry->make(spec, model);
  return Fail(ErrorCode::kInvalidArgument,
              "network '{}' is none that this program knows: use the program that wrote it", Shown(network));
}

}  // namespace dadrl
