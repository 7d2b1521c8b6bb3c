#include "common/port/sample_queue.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace dadrl {

void SampleQueue::Push(const Sample& sample) {
  assert(!full());
  samples_.push_back(sample);
  if (keeps_last_ == 0) return;
  const auto same = [&](const Sample& other) { return other.key == sample.key; };
  const auto held = std::count_if(samples_.begin(), samples_.end(), same);
  if (static_cast<size_t>(held) > keeps_last_) {
    samples_.erase(std::find_if(samples_.begin(), samples_.end(), same));
  }
}

SampleQueue::Sample SampleQueue::Pop() {
  Sample sample = std::move(samples_.front());
  samples_.pop_front();
  return sample;
}

}  // namespace dadrl
