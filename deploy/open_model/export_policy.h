// A policy file's networks as plain arrays, for programs that are not ours (docs/open_models.md).
#pragma once

#include <filesystem>

#include "common/model/policy_file.h"
#include "common/util/result.h"

namespace dadrl {

// Writes into `directory`, which must be new or empty: <network>/<tensor>.npy for each network of the file;
// config.yaml; and last index.json, so that an export without it is incomplete. `source` is the policy file's
// name, for the index and for errors. kInvalidArgument when the file is of other networks or the folder holds
// anything. Blocks on the disk.
Status ExportPolicy(const PolicyFile& policy, const std::filesystem::path& source,
                    const std::filesystem::path& directory);

}  // namespace dadrl
