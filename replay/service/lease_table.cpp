#include "replay/service/lease_table.h"

#include <fmt/format.h>

#include <algorithm>

namespace dadrl {

bool LeaseTable::Live(const Lease& lease, TimePoint now) {
  return !lease.left && now - lease.renewed < kLeaseTerm;
}

LeaseTable::Answer LeaseTable::Ask(const Request& request, TimePoint now, uint64_t least) {
  const std::optional<uint32_t> number = NumberFor(request, now);
  if (!number || *number > kMaxNumber) {
    return {.verdict = LeaseVerdict::kHeld,
            .reason = number ? fmt::format("actor number {} is above {}", *number, kMaxNumber)
                             : fmt::format("all {} actor numbers are taken", kMaxLeases)};
  }
  const auto found = leases_.find(*number);
  if (found == leases_.end()) return AskFree(*number, request, now, least);
  if (found->second.token == request.token) return AskOwn(*number, found->second, request, now, least);
  return AskOthers(*number, found->second, request, now, least);
}

std::optional<uint32_t> LeaseTable::NumberFor(const Request& request, TimePoint now) {
  if (request.number) return request.number;
  if (const auto own = by_token_.find(request.token); own != by_token_.end()) {
    const auto lease = leases_.find(own->second);
    if (lease != leases_.end() && lease->second.token == request.token) return own->second;
  }
  for (auto it = leases_.lower_bound(kFirstAny); it != leases_.end(); ++it) {
    if (it->second.left || now - it->second.renewed >= kReuseAfter) return it->first;
  }
  if (leases_.size() >= kMaxLeases) return std::nullopt;
  while (next_any_ > kMaxNumber || leases_.contains(next_any_)) {
    next_any_ = next_any_ >= kMaxNumber ? kFirstAny : next_any_ + 1;
  }
  return next_any_;
}

LeaseTable::Answer LeaseTable::AskOwn(uint32_t number, Lease& lease, const Request& request, TimePoint now,
                                      uint64_t least) {
  if (request.start < lease.start) {
    return {.verdict = LeaseVerdict::kLost,
            .number = number,
            .reason = fmt::format("actor number {} was taken over by a later process of the same actor ({})",
                                  number, lease.who)};
  }
  if (request.start > lease.start) {
    const uint64_t fresh = std::max({request.start, lease.incarnation + 1, least});
    return Grant(number, request, request.incarnation > lease.incarnation ? request.incarnation : fresh, now);
  }
  lease.renewed = now;
  lease.left = request.leaving;
  return {.number = number, .incarnation = lease.incarnation};
}

LeaseTable::Answer LeaseTable::AskOthers(uint32_t number, Lease& lease, const Request& request, TimePoint now,
                                         uint64_t least) {
  // Shown by one that got it later, before this process began.
  if (request.incarnation > lease.incarnation) return Grant(number, request, request.incarnation, now);
  const bool live = Live(lease, now);
  if (request.incarnation == 0 && !live) {
    return Grant(number, request, std::max({request.start, lease.incarnation + 1, least}), now);
  }
  const double seconds = ToSeconds(now - lease.since);
  if (request.incarnation != 0) {
    return {
        .verdict = LeaseVerdict::kLost,
        .number = number,
        .reason = fmt::format("actor number {} went to another actor ({}) {:.0f} s ago, when this one had "
                              "been silent for more than {:.0f} s",
                              number, lease.who, seconds, ToSeconds(kLeaseTerm))};
  }
  return {
      .verdict = LeaseVerdict::kHeld,
      .number = number,
      .reason = fmt::format("actor number {} is held by {}, for {:.0f} s now; choose another --first-index, "
                            "or leave it away: the run then gives out a free number",
                            number, lease.who, seconds)};
}

LeaseTable::Answer LeaseTable::AskFree(uint32_t number, const Request& request, TimePoint now,
                                       uint64_t least) {
  if (leases_.size() >= kMaxLeases) {
    return {.verdict = LeaseVerdict::kHeld,
            .reason = fmt::format("all {} actor numbers are taken", kMaxLeases)};
  }
  if (request.incarnation != 0) return Grant(number, request, request.incarnation, now);
  if (number >= reserved_ && now - opened_ < kLeaseTerm) {
    return {.verdict = LeaseVerdict::kWait,
            .number = number,
            .reason = "the replay has just started, and hears first who has which number"};
  }
  return Grant(number, request, std::max(request.start, least), now);
}

LeaseTable::Answer LeaseTable::Grant(uint32_t number, const Request& request, uint64_t incarnation,
                                     TimePoint now) {
  Lease& lease = leases_[number];
  if (lease.token != request.token) by_token_.erase(lease.token);
  lease = {.token = request.token,
           .start = request.start,
           .incarnation = incarnation,
           .who = request.who,
           .since = now,
           .renewed = now,
           .left = request.leaving};
  by_token_[request.token] = number;
  return {.number = number, .incarnation = incarnation};
}

}  // namespace dadrl
