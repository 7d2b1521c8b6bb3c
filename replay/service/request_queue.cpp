#include "replay/service/request_queue.h"

#include <algorithm>

namespace dadrl {

RequestQueue::Verdict RequestQueue::OnArrival(const Id& id, uint64_t oldest_open) {
  if (id.learner < learner_) return Verdict::kSuperseded;
  if (id.learner > learner_) {
    learner_ = id.learner;
    oldest_open_ = 0;
    pending_.clear();
  }
  // No request is newer than itself: what a learner says of the future is not believed.
  oldest_open_ = std::max(oldest_open_, std::min(oldest_open, id.number));
  std::erase_if(pending_, [this](const Request& request) { return request.id.number < oldest_open_; });
  if (id.number < oldest_open_) return Verdict::kGivenUp;
  const auto known = std::find_if(pending_.begin(), pending_.end(),
                                  [&](const Request& request) { return request.id == id; });
  if (known == pending_.end()) return Verdict::kNew;
  known->notified = false;
  return Verdict::kKnown;
}

void RequestQueue::Push(const Request& request) {
  pending_.push_back(request);
  if (pending_.size() > kMaxPending) pending_.pop_front();
}

}  // namespace dadrl
