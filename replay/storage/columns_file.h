// `columns.json` beside the segments: what their steps hold, for whoever reads them without the run.
#pragma once

#include <filesystem>
#include <string_view>

#include "common/step/step_spec.h"

namespace dadrl {

constexpr std::string_view kColumnsFile = "columns.json";

// Atomic and durable; blocks on the disk. Leaves a file that says the same alone.
Status WriteColumns(const std::filesystem::path& directory, const StepSpec& spec);

// What the segments of `directory` with this schema hold: as its file says, or without one as all experience
// was before there were such files. kCorrupt: neither fits the schema.
Result<StepSpec> ReadColumns(const std::filesystem::path& directory, uint64_t schema);

}  // namespace dadrl
