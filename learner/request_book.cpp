#include "learner/request_book.h"

#include <algorithm>

namespace dadrl {

RequestBook::RequestBook(int shards, int credits, Duration timeout)
    : credits_(static_cast<size_t>(credits)), timeout_(timeout), shards_(static_cast<size_t>(shards)) {
  open_.reserve(credits_ * shards_.size());
  due_.reserve(credits_ * shards_.size());
}

const std::vector<RequestBook::Request>& RequestBook::Due(TimePoint now, int ready) {
  due_.clear();
  if (shards_.size() > 1) {
    std::erase_if(open_, [&](const Open& open) {
      if (open.withheld || now - open.sent < timeout_) return false;
      shards_[open.request.shard].avoided_until = now + timeout_;
      ++given_up_;
      return true;
    });
  }
  for (Open& open : open_) {
    if (!open.repeat && now - open.sent < timeout_) continue;
    open.repeat = false;
    open.sent = now;
    due_.push_back(open.request);
    ++repeated_;
  }
  while (now >= hold_off_until_ && Active() + static_cast<size_t>(ready) < credits_) {
    const std::optional<uint32_t> shard = ChooseShard(now);
    if (!shard) break;
    const Request request{*shard, next_number_++};
    open_.push_back({.request = request, .sent = now});
    due_.push_back(request);
  }
  return due_;
}

size_t RequestBook::Active() const {
  if (shards_.size() == 1) return open_.size();
  return static_cast<size_t>(
      std::count_if(open_.begin(), open_.end(), [](const Open& open) { return !open.withheld; }));
}

bool RequestBook::Withholds(uint32_t shard) const {
  return std::any_of(open_.begin(), open_.end(),
                     [&](const Open& open) { return open.withheld && open.request.shard == shard; });
}

RequestBook::Open* RequestBook::Find(const Request& reply) {
  const auto found = std::find_if(open_.begin(), open_.end(), [&](const Open& open) {
    return open.request.number == reply.number && open.request.shard == reply.shard;
  });
  return found == open_.end() ? nullptr : &*found;
}

bool RequestBook::OnReply(const Request& reply, uint64_t frames_held) {
  const Open* open = Find(reply);
  if (open == nullptr) return false;
  Shard& shard = shards_[reply.shard];
  shard.frames_held = frames_held;
  shard.known = true;
  shard.avoided_until = {};
  open_.erase(open_.begin() + (open - open_.data()));
  return true;
}

bool RequestBook::OnWithheld(const Request& reply, uint64_t frames_held, TimePoint now) {
  Open* open = Find(reply);
  if (open == nullptr) return false;
  open->withheld = true;
  open->sent = now;
  Shard& shard = shards_[reply.shard];
  shard.frames_held = frames_held;
  shard.known = true;
  shard.avoided_until = {};
  return true;
}

void RequestBook::RepeatAll() {
  for (Open& open : open_) {
    open.repeat = true;
    open.withheld = false;  // the shard that said so may be gone
  }
}

uint64_t RequestBook::oldest_open(uint32_t shard) const {
  uint64_t oldest = next_number_;
  for (const Open& open : open_) {
    if (open.request.shard == shard) oldest = std::min(oldest, open.request.number);
  }
  return oldest;
}

bool RequestBook::all_withheld() const {
  return !open_.empty() &&
         std::all_of(open_.begin(), open_.end(), [](const Open& open) { return open.withheld; });
}

TimePoint RequestBook::next_due(TimePoint now) const {
  TimePoint next = TimePoint::max();
  for (const Open& open : open_) next = std::min(next, open.repeat ? now : open.sent + timeout_);
  if (Active() < credits_ && now < hold_off_until_) next = std::min(next, hold_off_until_);
  return next;
}

uint64_t RequestBook::frames_held() const {
  uint64_t sum = 0;
  for (const Shard& shard : shards_) sum += shard.frames_held;
  return sum;
}

// Smooth weighted round robin: every shard gains its weight, the richest pays for all and is chosen. Over any
// stretch the shares follow the weights. A shard that has not answered yet weighs as much as the fullest, so
// that it is asked; one that was silent is left out while another is not.
std::optional<uint32_t> RequestBook::ChooseShard(TimePoint now) {
  double fullest = 1.0;
  bool all_avoided = true;
  for (uint32_t i = 0; i < shards_.size(); ++i) {
    const Shard& shard = shards_[i];
    fullest = std::max<double>(fullest, shard.frames_held);
    all_avoided = all_avoided && (now < shard.avoided_until || Withholds(i));
  }
  double total = 0.0;
  std::optional<uint32_t> chosen;
  for (uint32_t i = 0; i < shards_.size(); ++i) {
    Shard& shard = shards_[i];
    if (Withholds(i) || (now < shard.avoided_until && !all_avoided)) continue;
    const double weight = shard.known ? std::max<double>(1.0, shard.frames_held) : fullest;
    shard.turn += weight;
    total += weight;
    if (!chosen || shard.turn > shards_[*chosen].turn) chosen = i;
  }
  if (chosen) shards_[*chosen].turn -= total;
  return chosen;
}

}  // namespace dadrl
