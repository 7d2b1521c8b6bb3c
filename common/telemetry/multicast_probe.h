// Whether multicast works on this host, found out in a moment.
#pragma once

#include <string>

#include "common/util/result.h"

namespace dadrl {

// Sends a packet to `group` ("239.255.76.67"), on a port of its own and not beyond this host, and listens for
// it as LCM would. kUnavailable with the reason when it does not come back within a quarter of a second.
Status HearOwnMulticast(const std::string& group);

}  // namespace dadrl
