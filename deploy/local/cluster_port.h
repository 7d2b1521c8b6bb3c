// Which UDP ports a cluster on this machine takes.
#pragma once

#include <optional>

#include "common/config/config.h"
#include "common/util/result.h"

namespace dadrl {

// The first port for `config`: the configured one, or a free block when that is 0. A resumed run (`saved` is
// its earlier configuration) that did not ask for another port takes a free one when its own is taken now.
// kUnavailable when a port that was asked for is taken.
Result<int> ChoosePort(const Config& config, const std::optional<Config>& saved);

}  // namespace dadrl
