// What `dadrl replay limit` asks for.
#pragma once

#include "cluster.h"
#include "common/util/result.h"
#include "replay/rate_limiter.h"

namespace dadrl {

// `now` with what `command` changes; what it leaves out stays as it is (cluster.idl). kInvalidArgument names
// the value and its range, also when both sides would wait for each other.
Result<RateLimiter::Options> ChangedLimits(const RateLimiter::Options& now,
                                           const dadrl_idl_ReplayCommand& command);

}  // namespace dadrl
