// Observations as three arrays in a folder, the layout that `dadrl act` reads (docs/open_models.md).
#pragma once

#include <filesystem>

#include "common/step/columns.h"
#include "common/util/result.h"

namespace dadrl {

// Reads vehicles.npy [N, vehicles, history, 7] float32, ego.npy [N, history, 20] float32 and context.npy
// [N, 2, 128, 128] uint8, each pixel 0 or 1; at least one observation, at most kMaxRecordedObservations.
// Errors name the file, what is wrong and what is needed. Blocks on the disk.
Result<Columns> LoadRecordedObservations(const std::filesystem::path& directory, const StepSpec& spec);

constexpr size_t kMaxRecordedObservations = 20'000;  // 655 MB of pixels

}  // namespace dadrl
