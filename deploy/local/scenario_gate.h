// Whether a scenario can be driven, asked before anything starts.
#pragma once

#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/util/result.h"
#include "deploy/local/signals.h"

namespace dadrl {

// Lets dadrl-actor check config.scenario ("all": every one) in a process of its own, because SUMO can abort:
// what `dadrl scenario check` refuses is refused here, in the same words. Returns its warnings. Takes about a
// second; `signals` end it (kUnavailable), if there are any to watch.
Result<std::vector<std::string>> CheckDrivable(const Config& config, SignalWatcher* signals);

}  // namespace dadrl
