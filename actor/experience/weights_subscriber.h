// The learner's broadcast policy, checked before anyone acts with it.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "actor/experience/experience_sink.h"
#include "common/dds/node.h"
#include "common/port/port.h"
#include "proto/topics.h"

namespace dadrl {

// TakeNewer belongs to one thread; the counters may be read by any. What CheckWeights refuses is counted, the
// first of it is logged, and the policy in use stays.
class WeightsSubscriber final : public PolicySource {
 public:
  // `parameter_count`, `layout_hash`: of the PolicyModel that will load them. Borrows `transport`.
  static Result<std::unique_ptr<WeightsSubscriber>> Create(const Transport& transport, size_t parameter_count,
                                                           uint64_t layout_hash);

  uint32_t TakeNewer(uint32_t have, std::vector<float>& parameters) override;

  // Wall time at which the policy that was taken last was published, ns; 0 before the first.
  int64_t published_ns() const { return published_ns_; }
  uint64_t refused() const { return refused_; }
  // Of the refused: built for another network.
  uint64_t refused_layouts() const { return refused_layouts_; }

 private:
  WeightsSubscriber(size_t parameter_count, uint64_t layout_hash)
      : parameter_count_(parameter_count), layout_hash_(layout_hash) {}

  const size_t parameter_count_;
  const uint64_t layout_hash_;
  std::unique_ptr<Reader<dadrl_idl_Weights>> reader_;
  std::atomic<int64_t> published_ns_{0};
  std::atomic<uint64_t> refused_{0};
  std::atomic<uint64_t> refused_layouts_{0};
};

}  // namespace dadrl
