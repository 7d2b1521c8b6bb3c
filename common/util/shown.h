// Text from outside as a part of a one-line message.
#pragma once

#include <string>
#include <string_view>

namespace dadrl {

// `text` without control characters (\xNN stands for each), cut to `most` bytes with "..." behind them.
std::string Shown(std::string_view text, size_t most = 60);

}  // namespace dadrl
