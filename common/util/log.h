// Process-wide logging on spdlog: standard error only, so that standard output stays free for results.
#pragma once

#include <spdlog/spdlog.h>

#include <memory>
#include <string>

namespace dadrl {

// Call once at the start of main. `role` ("actor-3", "replay") stands in every line.
void InitLogging(const std::string& role);

// Time, level, role and message, on one line whatever the message holds: no text from outside forges a line
// or steers the terminal.
std::unique_ptr<spdlog::formatter> LogFormatter();

}  // namespace dadrl
