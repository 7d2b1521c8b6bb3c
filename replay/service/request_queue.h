// Which batch requests wait at a shard, and of which learner: the batch server's bookkeeping, without clock
// or network.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>

#include "common/step/trajectory_batch.h"

namespace dadrl {

// Requests of one learner, the latest that has spoken, in the order of their first arrival. Whatever arrives
// late, twice or in masses (of a learner that was restarted, or that repeated itself while this shard was
// stopped) is settled here, never an error. Bounded: of more than kMaxPending the oldest go; their learner
// has given them up, or asks again. Not thread safe.
class RequestQueue {
 public:
  static constexpr size_t kMaxPending = 64;

  struct Id {
    uint64_t learner = 0;  // incarnation
    uint64_t number = 0;   // 1, 2, 3, ...
    bool operator==(const Id&) const = default;
  };
  struct Request {
    Id id;
    TrajectoryShape shape;
    uint32_t policy_version = 0;  // newest, for the staleness limit
    bool notified = false;        // that it is withheld
  };

  enum class Verdict {
    kNew,         // to be checked, and pushed
    kKnown,       // it waits already: who asks again hears again
    kGivenUp,     // a late copy of one that the learner no longer waits for
    kSuperseded,  // its learner is not the latest
  };

  // A request arrived. `oldest_open`: the learner waits for none of its requests below it. A later learner
  // than the present one clears the queue.
  Verdict OnArrival(const Id& id, uint64_t oldest_open);
  void Push(const Request& request);

  bool empty() const { return pending_.empty(); }
  size_t size() const { return pending_.size(); }
  uint64_t learner() const { return learner_; }
  Request& front() { return pending_.front(); }
  void Pop() { pending_.pop_front(); }
  std::deque<Request>& pending() { return pending_; }

 private:
  uint64_t learner_ = 0;
  uint64_t oldest_open_ = 0;
  std::deque<Request> pending_;
};

}  // namespace dadrl
