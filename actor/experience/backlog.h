// What an actor has produced and the replay has not yet acknowledged, and what to send of it next. Pure
// bookkeeping: no thread, no clock, no network.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "common/util/clock.h"

namespace dadrl {

// Go-back-N with credits. Chunks carry the sequences 1, 2, 3, ...; all up to `acknowledged` are stored and
// forgotten here, the rest is kept. The replay grants sequences it is willing to take; what was sent and not
// acknowledged is sent again when a new replay process appears or nothing is acknowledged for a while. The
// replay drops what it has already.
// Not thread safe.
class Backlog {
 public:
  struct Chunk {
    uint64_t sequence = 0;
    std::vector<std::byte> bytes;
  };

  // Shortest and longest wait for an acknowledgement before sending again: twice what the last one took, and
  // it doubles while none comes.
  static constexpr Duration kFirstResend = std::chrono::seconds(1);
  static constexpr Duration kLastResend = std::chrono::seconds(8);
  // No replay has room for more chunks of one actor: a grant of more is taken for so many.
  static constexpr uint64_t kMaxGrant = 1024;

  enum class AckEffect {
    kAccepted,
    kForgotten,  // the replay stores less than it once said: what lies between is lost, and one chunk tells
                 // it where we are
    kInvalid,    // acknowledges what was never produced; ignored
  };

  // Sequences must be consecutive, from 1.
  void Add(Chunk chunk);
  AckEffect OnAcknowledgement(uint64_t stored, uint64_t granted, TimePoint now);
  // A replay process appeared, the first or another: nothing beyond `acknowledged` is known to be with it.
  // Until it speaks, one chunk introduces us.
  void OnNewPeer(TimePoint now);

  // What to send now; null when there is nothing or the grant is used up. Valid until the next call.
  const Chunk* Next(TimePoint now);
  // The chunk of the last Next left.
  void OnSent(TimePoint now);

  uint64_t last_sequence() const { return last_; }
  // The lowest that can still be sent.
  uint64_t oldest_kept() const { return acknowledged_ + 1; }
  uint64_t acknowledged() const { return acknowledged_; }
  uint64_t granted() const { return granted_; }
  size_t bytes() const { return bytes_; }
  uint64_t resent_chunks() const { return resent_; }

 private:
  void SendFromAcknowledged(TimePoint now);

  std::deque<Chunk> chunks_;  // acknowledged_ + 1 ... last_
  size_t bytes_ = 0;
  uint64_t last_ = 0;
  uint64_t acknowledged_ = 0;
  uint64_t granted_ = 0;
  uint64_t next_ = 1;        // to be sent
  uint64_t sent_up_to_ = 0;  // highest ever sent: what comes below is sent again
  uint64_t resent_ = 0;
  bool heard_ = false;    // the present replay has spoken
  TimePoint progress_{};  // of the last acknowledgement, or of the first send after one
  Duration resend_after_ = kFirstResend;
};

}  // namespace dadrl
