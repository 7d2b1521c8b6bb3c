// Which batch requests are out, to which shard, and which to send next: the fetcher's bookkeeping, without
// clock or network.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/util/clock.h"

namespace dadrl {

// A credit covers one batch from its request until the trainer takes it, so that no more than `credits`
// batches are ever under way or waiting. Requests go to shards in proportion to the frames they hold. A
// request that stays unanswered is sent again with the same number; with several shards it is given up and
// its credit goes to another shard. A shard that withholds a batch (too little experience yet, enough
// samples) keeps the request and gets no other, and the credit goes to another shard too: one that waits for
// its actors does not hold up training. So up to credits x shards batches may be under way. Not thread safe.
class RequestBook {
 public:
  struct Request {
    uint32_t shard = 0;
    uint64_t number = 0;
  };

  RequestBook(int shards, int credits, Duration timeout);

  // The requests to send now: new ones for the credits that neither an open request nor one of the `ready`
  // batches holds, and those to repeat. Counts them as sent at `now`.
  const std::vector<Request>& Due(TimePoint now, int ready);

  // A reply came. False when its request is not open (given up, answered before, or never sent).
  bool OnReply(const Request& reply, uint64_t frames_held);
  // The shard holds the request back; it stays open, and its time-out starts anew.
  bool OnWithheld(const Request& reply, uint64_t frames_held, TimePoint now);

  // A shard (re)appeared: every open request is due at once.
  void RepeatAll();
  // No new requests before `until`: what comes back is useless, do not ask in a tight loop.
  void HoldOff(TimePoint until) { hold_off_until_ = until; }

  // The lowest number that `shard` was asked for and still owes; the next number when it owes none.
  uint64_t oldest_open(uint32_t shard) const;

  bool idle() const { return open_.empty(); }
  // Requests are open, and each of them is withheld.
  bool all_withheld() const;
  // When Due may next have something by the passing of time alone; TimePoint::max() when never.
  TimePoint next_due(TimePoint now) const;

  uint64_t repeated() const { return repeated_; }
  uint64_t given_up() const { return given_up_; }
  // Over all shards, as last reported.
  uint64_t frames_held() const;

 private:
  struct Open {
    Request request;
    TimePoint sent;
    bool withheld = false;
    bool repeat = false;
  };
  struct Shard {
    uint64_t frames_held = 0;
    bool known = false;         // has ever answered
    TimePoint avoided_until{};  // did not answer in time
    double turn = 0.0;          // smooth weighted round robin
  };

  Open* Find(const Request& reply);
  // Open requests that hold a credit.
  size_t Active() const;
  bool Withholds(uint32_t shard) const;
  // Nothing when every shard withholds.
  std::optional<uint32_t> ChooseShard(TimePoint now);

  const size_t credits_;
  const Duration timeout_;
  std::vector<Shard> shards_;
  std::vector<Open> open_;
  std::vector<Request> due_;
  TimePoint hold_off_until_{};
  uint64_t next_number_ = 1;
  uint64_t repeated_ = 0;
  uint64_t given_up_ = 0;
};

}  // namespace dadrl
