// Asks a running cluster for its configuration: what a machine needs to join it.
#pragma once

#include <functional>
#include <string>

#include "common/config/config.h"
#include "common/util/clock.h"
#include "common/util/result.h"

namespace dadrl {

// The configuration of the run at `host`, as its shard 0 announces it, with cluster.host set to `host`.
// `port` is its cluster.port; 0 looks at every port a launcher may have taken, which takes a few seconds.
// Blocks; `stop` ends it. kUnavailable: nobody answers. kInvalidArgument: `host` is unknown, or several
// clusters run there (the message names their ports).
Result<Config> FindRun(const std::string& host, int port, Duration patience,
                       const std::function<bool()>& stop);

}  // namespace dadrl
