// Asks a running cluster for its configuration: what a machine needs to join it.
#pragma once

#include <functional>
#include <string>

#include "common/config/config.h"
#include "common/util/clock.h"
#include "common/util/result.h"

namespace dadrl {

// Where a run is looked for.
struct RunPlace {
  std::string host;  // a name or an address
  int port = 0;      // its cluster.port; 0: every port a launcher may have taken, which takes a few seconds
  std::string key;   // the run's, or "": a run on 127.0.0.1, or with cluster.require_key, hears nobody else
  int mtu = 0;       // as cluster.mtu
};

// "HOST" or "HOST:PORT". kInvalidArgument with what is wrong of it.
Result<RunPlace> ParseRunPlace(const std::string& text);

// The configuration of the run, as its shard 0 announces it, with cluster.host set to the address of `host`.
// Blocks; `stop` ends it. kUnavailable: nobody answers. kInvalidArgument: the host is unknown, or several
// clusters run there (the message names their ports).
Result<Config> FindRun(const RunPlace& place, Duration patience, const std::function<bool()>& stop);

}  // namespace dadrl
