// Who has which actor number: replay shard 0's bookkeeping, without clock or network.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "common/util/clock.h"
#include "proto/lease.h"

namespace dadrl {

// At any time at most one process holds a number, and a number never comes back with an incarnation that it
// had before, so that the chunks of two holders are never mixed. A lease ends when its holder leaves or is
// silent for kLeaseTerm. Nothing is kept over a restart of the replay: holders show what they hold, and for
// the first kLeaseTerm nobody new gets a number that one of them may show; of two that show the same number
// the higher incarnation has it. Bounded: kMaxLeases numbers. Not thread safe.
class LeaseTable {
 public:
  static constexpr uint32_t kMaxNumber = 1'000'000;
  // Numbers that are given out to who wants any.
  static constexpr uint32_t kFirstAny = 10'000;
  static constexpr size_t kMaxLeases = 65536;
  // A number whose holder fell silent is given to somebody else only when that one asks for this very number,
  // or so much later: a holder that was cut off for a while finds its number again.
  static constexpr Duration kReuseAfter = std::chrono::minutes(10);

  struct Request {
    LeaseToken token;
    uint64_t start = 0;  // wanted incarnation; of two processes of one token the later has the higher
    std::optional<uint32_t> number;  // that it has or wants; nothing: any
    uint64_t incarnation = 0;        // that it holds the number with; 0: it has none yet
    bool leaving = false;
    std::string who;  // "HOST, pid 7"
  };
  struct Answer {
    LeaseVerdict verdict = LeaseVerdict::kGranted;
    uint32_t number = 0;
    uint64_t incarnation = 0;
    std::string reason{};  // unless granted
  };

  // `reserved`: the run's own actors have the numbers below it, and nobody waits for them after a restart.
  // `first_any`: from kFirstAny up, where numbers for anybody begin; drawn at random, so that after a restart
  // they seldom meet those of holders that are cut off.
  LeaseTable(uint32_t reserved, uint32_t first_any, TimePoint now)
      : reserved_(reserved), next_any_(first_any), opened_(now) {}

  // `least`: no new holder gets a lower incarnation.
  Answer Ask(const Request& request, TimePoint now, uint64_t least);

 private:
  struct Lease {
    LeaseToken token;
    uint64_t start = 0;
    uint64_t incarnation = 0;
    std::string who;
    TimePoint since{};
    TimePoint renewed{};
    bool left = false;
  };

  static bool Live(const Lease& lease, TimePoint now);
  std::optional<uint32_t> NumberFor(const Request& request, TimePoint now);
  Answer AskOwn(uint32_t number, Lease& lease, const Request& request, TimePoint now, uint64_t least);
  Answer AskOthers(uint32_t number, Lease& lease, const Request& request, TimePoint now, uint64_t least);
  Answer AskFree(uint32_t number, const Request& request, TimePoint now, uint64_t least);
  Answer Grant(uint32_t number, const Request& request, uint64_t incarnation, TimePoint now);

  const uint32_t reserved_;
  uint32_t next_any_;
  const TimePoint opened_;
  std::map<uint32_t, Lease> leases_;         // by number, those that ended included
  std::map<LeaseToken, uint32_t> by_token_;  // the number that it had last
};

}  // namespace dadrl
