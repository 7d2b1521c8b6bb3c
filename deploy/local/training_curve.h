// How far the learner is, from the table that it writes itself: telemetry can be forged, this cannot.
#pragma once

#include <cstdint>
#include <filesystem>

namespace dadrl {

struct TrainedSoFar {
  uint64_t updates = 0;  // over all sessions of the run
  double cpu_s = 0.0;    // of the learner, the same
  uint32_t weights_version = 0;
};

// The last row of logs/training.csv; zeros when there is none yet. Blocks on the disk.
TrainedSoFar LastOfTraining(const std::filesystem::path& training_csv);

}  // namespace dadrl
