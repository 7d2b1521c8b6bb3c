// What a memory port holds of a topic, and what it lets go of.
#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <string>

#include "common/port/topic.h"

namespace dadrl {

// In the order of arrival. Not thread safe.
class SampleQueue {
 public:
  struct Sample {
    std::shared_ptr<const void> value;
    std::string key;
  };

  // A reader's: keeps what the topic's QoS promises.
  static SampleQueue OfReader(const TopicSpec& topic) {
    if (topic.reader_keeps_last > 0) return {static_cast<size_t>(topic.reader_keeps_last), 0};
    if (!topic.keep_all) return {static_cast<size_t>(topic.depth), 0};
    return {0, static_cast<size_t>(topic.reader_max_samples)};
  }
  // A transient-local writer's: what a late reader gets.
  static SampleQueue OfWriter(const TopicSpec& topic) { return {static_cast<size_t>(topic.depth), 0}; }

  bool empty() const { return samples_.empty(); }
  bool full() const { return most_ > 0 && samples_.size() >= most_; }
  const std::deque<Sample>& samples() const { return samples_; }

  // Not when full. Of one key more than it keeps, the oldest goes.
  void Push(const Sample& sample);
  // Not when empty.
  Sample Pop();

 private:
  SampleQueue(size_t keeps_last, size_t most) : keeps_last_(keeps_last), most_(most) {}

  size_t keeps_last_;  // of each key; 0: all
  size_t most_;        // of all keys; 0: unlimited
  std::deque<Sample> samples_;
};

}  // namespace dadrl
