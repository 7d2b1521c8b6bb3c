// Asks the shards of a running cluster to do something, and waits for what they say.
#pragma once

#include <filesystem>

#include "common/util/result.h"
#include "proto/topics.h"

namespace dadrl {

// Sends `command` to every shard of the run in `run_directory` and prints each answer, on standard output as
// one JSON object when `json`; on standard error whom it waits for, when that takes long. The exit code: 1
// when a shard could not do it. kUnavailable: not all shards answered (replay_question.h).
Result<int> AskReplay(const std::filesystem::path& run_directory, const dadrl_idl_ReplayCommand& command,
                      bool json);

}  // namespace dadrl
