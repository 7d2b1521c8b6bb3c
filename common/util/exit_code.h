// Exit codes that a supervisor tells apart, beside 0, 1 and 2 (result.h).
#pragma once

namespace dadrl {

// Another process has this one's place in the run: starting it again would not help.
inline constexpr int kExitTurnedAway = 3;

}  // namespace dadrl
