#include "actor/experience/weights_subscriber.h"

#include <cstring>
#include <span>

#include "common/io/checksum.h"
#include "common/util/log.h"

namespace dadrl {
namespace {

std::span<const std::byte> BytesOf(const dadrl_idl_Weights& weights) {
  return {reinterpret_cast<const std::byte*>(weights.parameters._buffer), weights.parameters._length};
}

}  // namespace

Result<std::unique_ptr<WeightsSubscriber>> WeightsSubscriber::Create(const dds::Node& node,
                                                                     size_t parameter_count,
                                                                     uint64_t layout_hash) {
  std::unique_ptr<WeightsSubscriber> subscriber(new WeightsSubscriber(parameter_count, layout_hash));
  DADRL_ASSIGN_OR_RETURN(subscriber->reader_, dds::Reader<dadrl_idl_Weights>::Create(node, kWeightsTopic));
  return subscriber;
}

uint32_t WeightsSubscriber::TakeNewer(uint32_t have, std::vector<float>& parameters) {
  uint32_t newest = have;
  reader_->Take(1 << 20, [&](const dadrl_idl_Weights& weights) {
    const Status status = Check(weights);
    if (!status) {
      if (refused_++ == 0) spdlog::error("refused weights: {}", status.error().message);
      return;
    }
    if (weights.version <= newest) return;
    newest = weights.version;
    published_ns_ = weights.published_ns;
    const std::span<const std::byte> bytes = BytesOf(weights);
    parameters.resize(parameter_count_);
    std::memcpy(parameters.data(), bytes.data(), bytes.size());
  });
  return newest > have ? newest : 0;
}

Status WeightsSubscriber::Check(const dadrl_idl_Weights& weights) {
  if (weights.layout_hash != layout_hash_) {
    ++refused_layouts_;
    return Fail(ErrorCode::kInvalidArgument,
                "version {} is of another network (layout {:016x}, ours {:016x}): start this actor with the "
                "configuration of the learner",
                weights.version, weights.layout_hash, layout_hash_);
  }
  const std::span<const std::byte> bytes = BytesOf(weights);
  if (bytes.size() != parameter_count_ * sizeof(float)) {
    return Fail(ErrorCode::kCorrupt, "version {} has {} bytes, not {}", weights.version, bytes.size(),
                parameter_count_ * sizeof(float));
  }
  if (weights.version == 0) return Fail(ErrorCode::kCorrupt, "version 0 does not exist");
  if (Xxh3(bytes) != weights.checksum) {
    return Fail(ErrorCode::kCorrupt, "the checksum of version {} does not fit", weights.version);
  }
  return {};
}

}  // namespace dadrl
