#include "actor/experience/weights_subscriber.h"

#include <cstring>
#include <span>

#include "common/util/log.h"
#include "proto/weights.h"

namespace dadrl {
Result<std::unique_ptr<WeightsSubscriber>> WeightsSubscriber::Create(const Transport& transport,
                                                                     size_t parameter_count,
                                                                     uint64_t layout_hash) {
  std::unique_ptr<WeightsSubscriber> subscriber(new WeightsSubscriber(parameter_count, layout_hash));
  DADRL_ASSIGN_OR_RETURN(subscriber->reader_, Reader<dadrl_idl_Weights>::Create(transport, kWeightsTopic));
  return subscriber;
}

uint32_t WeightsSubscriber::TakeNewer(uint32_t have, std::vector<float>& parameters) {
  uint32_t newest = have;
  reader_->Take(1 << 20, [&](const dadrl_idl_Weights& weights) {
    if (const Status status = CheckWeights(weights, parameter_count_, layout_hash_); !status) {
      if (status.error().code == ErrorCode::kInvalidArgument) ++refused_layouts_;
      if (refused_++ == 0) spdlog::error("refused weights: {}", status.error().message);
      return;
    }
    if (weights.version <= newest) return;
    newest = weights.version;
    published_ns_ = weights.published_ns;
    const std::span<const std::byte> bytes = ParameterBytes(weights);
    parameters.resize(parameter_count_);
    std::memcpy(parameters.data(), bytes.data(), bytes.size());
  });
  return newest > have ? newest : 0;
}

}  // namespace dadrl
