// Where a cluster that starts on this machine is reached.
#pragma once

#include <string>
#include <vector>

#include "common/dds/address.h"
#include "common/util/result.h"

namespace dadrl {

// The address of `host` (cluster.host, a name or an address) in dotted form, when a cluster can be reached
// there. Blocks on the resolver, once for the whole run. kInvalidArgument with what else there is.
Result<std::string> ClusterAddress(const std::string& host);

// The check without the resolver: `address` is what `host` was resolved to, `local` what this machine has.
Status CheckClusterAddress(const std::string& host, const std::string& address,
                           const std::vector<dds::LocalAddress>& local);

}  // namespace dadrl
