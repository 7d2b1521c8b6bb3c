// The curves of a training: logs/training.csv and TensorBoard events, a row an interval.
#pragma once

#include <cstdint>
#include <filesystem>

#include "common/util/result.h"
#include "common/util/time_ledger.h"
#include "learner/csv_log.h"
#include "learner/tensorboard_writer.h"
#include "learner/trainer.h"

namespace dadrl {

// What a row says beside the training interval itself.
struct LogContext {
  double wall_time_s = 0.0;  // Unix time by the system's clock
  double interval_s = 0.0;   // how long the interval was
  double batch_bytes = 0.0;  // received in the interval
  double replay_frames = 0.0;
  double work_fraction = 0.0;  // of the training thread's time in the interval
};

// Not thread safe. Its times never go back, also when the system's clock was set back. A write that fails is
// logged once and tried again with the next row: a full disk does not stop a training.
class TrainingLog {
 public:
  // Goes on behind what earlier learners of the run wrote; `updates`: where this one begins.
  static Result<TrainingLog> Open(const std::filesystem::path& run_directory, uint64_t updates);
  void Add(const TrainingInterval& interval, const LogContext& context);

 private:
  TrainingLog(CsvLog csv, TensorBoardWriter tensorboard)
      : csv_(std::move(csv)), tensorboard_(std::move(tensorboard)), wall_time_s_(csv_.last_row_start()) {}

  CsvLog csv_;
  TensorBoardWriter tensorboard_;
  double wall_time_s_ = 0.0;  // of the last row, earlier sessions' included
  bool failing_ = false;
};

}  // namespace dadrl
