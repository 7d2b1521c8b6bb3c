// Cyclone DDS's own messages, sent to the process's log.
#pragma once

namespace dadrl::dds {

// Routes warnings and errors of Cyclone DDS to the log, each place in its source at most once in ten seconds
// (a link that is down would print dozens of lines a second). Idempotent, thread safe.
void InstallLogSink();

}  // namespace dadrl::dds
