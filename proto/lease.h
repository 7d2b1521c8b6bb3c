// What actors and replay shard 0 agree on about actor numbers.
#pragma once

#include <compare>
#include <cstdint>

#include "common/util/clock.h"

namespace dadrl {

// Names an actor over its restarts: 128 random bits.
struct LeaseToken {
  uint64_t high = 0;
  uint64_t low = 0;
  auto operator<=>(const LeaseToken&) const = default;
};

// Silence after which a number is free, and how often its holder speaks.
constexpr Duration kLeaseTerm = std::chrono::seconds(6);
constexpr Duration kLeaseRenewal = std::chrono::milliseconds(1500);

enum class LeaseVerdict : uint32_t {
  kGranted = 0,
  kWait,          // ask again: whose the number is will be known soon
  kHeld,          // another has the number; it is free when that one's lease ends
  kLost,          // it was this actor's, and is another's by now
  kIncompatible,  // another version, or other observations
};

}  // namespace dadrl
