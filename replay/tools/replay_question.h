// A command for every shard of a running cluster, and what they answer.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "common/config/config.h"
#include "common/port/port.h"
#include "common/util/clock.h"
#include "common/util/result.h"
#include "proto/topics.h"

namespace dadrl {

struct ReplayAnswer {
  bool done = false;
  std::string text;  // printable
};

// Sends `command`, under a number of its own, until every shard has answered; by shard. `say` is told once
// whom it waits for, after three seconds. Blocks. kUnavailable, with the silent shards: they did not answer
// within a minute, or did not listen for longer than a shard that hangs needs to be back.
Result<std::map<uint32_t, ReplayAnswer>> AskShards(const Transport& transport, const Config& config,
                                                   dadrl_idl_ReplayCommand command, const Clock& clock,
                                                   const std::function<void(const std::string&)>& say);

}  // namespace dadrl
