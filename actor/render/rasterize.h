// SVG text to PNG bytes.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "common/util/result.h"

namespace dadrl {

// At the picture's own size times `zoom`. kInternal: librsvg cannot read it.
Result<std::vector<std::byte>> RasterizePng(std::string_view svg, double zoom = 1.0);

}  // namespace dadrl
