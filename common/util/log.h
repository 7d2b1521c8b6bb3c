// Process-wide logging on spdlog: standard error only, so that standard output stays free for results.
#pragma once

#include <spdlog/spdlog.h>

#include <string>

namespace dadrl {

// Call once at the start of main. `role` ("actor-3", "replay") stands in every line.
void InitLogging(const std::string& role);

}  // namespace dadrl
