#include "actor/experience/backlog.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace dadrl {

void Backlog::Add(Chunk chunk) {
  assert(chunk.sequence == last_ + 1);
  last_ = chunk.sequence;
  bytes_ += chunk.bytes.size();
  chunks_.push_back(std::move(chunk));
}

Backlog::AckEffect Backlog::OnAcknowledgement(uint64_t stored, uint64_t granted, TimePoint now) {
  if (stored > last_) return AckEffect::kInvalid;
  heard_ = stored >= acknowledged_;
  granted_ = std::min(std::max(granted, acknowledged_), std::max(stored, acknowledged_) + kMaxGrant);
  if (!heard_) return AckEffect::kForgotten;
  if (stored > acknowledged_) {
    // A disk that takes long makes acknowledgements rare, not lost.
    resend_after_ = std::clamp(2 * (now - progress_), kFirstResend, kLastResend);
    progress_ = now;
  }
  for (; acknowledged_ < stored; ++acknowledged_) {
    bytes_ -= chunks_.front().bytes.size();
    chunks_.pop_front();
  }
  next_ = std::max(next_, acknowledged_ + 1);
  return AckEffect::kAccepted;
}

void Backlog::OnNewPeer(TimePoint now) {
  heard_ = false;
  resend_after_ = kFirstResend;
  SendFromAcknowledged(now);
}

const Backlog::Chunk* Backlog::Next(TimePoint now) {
  const bool outstanding = next_ > acknowledged_ + 1;
  if (outstanding && now - progress_ >= resend_after_) {
    resend_after_ = std::min(2 * resend_after_, kLastResend);
    SendFromAcknowledged(now);
  }
  const uint64_t limit = heard_ ? granted_ : acknowledged_ + 1;
  if (next_ > last_ || next_ > limit) return nullptr;
  return &chunks_[next_ - acknowledged_ - 1];
}

void Backlog::OnSent(TimePoint now) {
  if (next_ == acknowledged_ + 1) progress_ = now;
  if (next_ <= sent_up_to_) ++resent_;
  sent_up_to_ = std::max(sent_up_to_, next_);
  ++next_;
}

void Backlog::SendFromAcknowledged(TimePoint now) {
  next_ = acknowledged_ + 1;
  progress_ = now;
}

}  // namespace dadrl
