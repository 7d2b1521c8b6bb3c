// Telemetry packets: checked before and after they are decoded, because anyone on this host can send one.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "proto/telemetry.h"

namespace dadrl {

std::vector<std::byte> EncodePacket(const ProcessStatus& status);
std::vector<std::byte> EncodePacket(const EpisodeReport& report);

// kCorrupt when length or type fingerprint differ, a number is not one that a run can produce, a process or
// outcome does not exist, or the sender counts other metrics than we do (another version of the program).
Result<ProcessStatus> DecodeStatusPacket(std::span<const std::byte> packet);
Result<EpisodeReport> DecodeEpisodePacket(std::span<const std::byte> packet);

}  // namespace dadrl
